"""Levenberg-Marquardt with a dense Jacobian, and Gauss-Newton with Krylov products."""

from __future__ import annotations

from typing import Any, final

import equinox as eqx
import jax
import jax.numpy as jnp
import lineax as lx
import numpy as np
import optimistix as optx
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float

from thermo._compiled import program
from thermo.inverse._objective import Objective, Parameters, jacobian, penalty, residual
from thermo.inverse._optimiser import AbstractOptimiser, Memory

# The first damping is light: the parameters are logarithms, of order one, and whitened residuals
# make the Gauss-Newton step a good one from the start.
FIRST_STEP = 1e2

# Largest change of a parameter in one step [1]; fields are logarithmic, so a factor e.
LONGEST = 1.0

# Trials in a row [1] that may fail where coarse tangents steer: from there they no longer know
# which way is down, and shorter steps along them would only cost time. That is no success.
STALLED = 3

# Halvings [1] of the range in which the least damping lies; and what a slope or a step counts as at
# least [1], so that nothing is divided by zero.
HALVINGS, TINY = 40, 1e-30

# Of the trust region: change of the loss, as a share of the predicted one [1], from which a step
# is accepted or good, and factors of the trust after a good and after a rejected step [1].
ACCEPTED, GOOD, WIDEN, NARROW = 0.01, 0.99, 3.5, 0.25


def _dense(
    objective: Objective, parameters: Parameters
) -> tuple[Float[Array, " all"], Float[Array, "all unknowns"]]:
    """The residual [1] and its Jacobian [1], or the one of the coarse tangents, at a point."""
    if objective.tangents is None:
        return jacobian(objective, parameters)
    _, matrix = jacobian(objective.tangents, parameters)
    return residual(objective, parameters), matrix


def _known(value: Float[Array, " all"], matrix: Float[Array, "all unknowns"]) -> Any:
    """A function as optimistix wants it, known at the one point where a step asks for it [1]."""

    @jax.custom_jvp
    def function(flat: Float[Array, " unknowns"]) -> Float[Array, " all"]:
        del flat
        return value

    @function.defjvp
    def _(point: Any, tangent: Any) -> Any:
        del point
        return value, matrix @ tangent[0]

    return lambda point, args: (function(point), None)


def _longest(move: Float[Array, " unknowns"], trust: Float[Array, ""]) -> Float[Array, ""]:
    """The largest change of a parameter [1] that a trust, an inverse damping [1], leaves of a step.

    Far from the answer a field can be so stiff that the data hardly change with it, and the
    undamped step leaves the bounds. And damping by the trust alone counts only once it is as large
    as the normal matrix, after many rejected steps of a run each.
    """
    return jnp.minimum(LONGEST, optx.max_norm(move)) * jnp.minimum(1.0, trust / FIRST_STEP)


def _shortened(
    move: Float[Array, " unknowns"], trust: Float[Array, ""]
) -> Float[Array, " unknowns"]:
    """The step [1] along its own way, no parameter changed by more than the trust allows."""
    longest = jnp.maximum(optx.max_norm(move), 1e-12)
    return move * jnp.minimum(1.0, _longest(move, trust) / longest)


@final
class _Near(eqx.Module):
    """The loss near the point where a fit stands.

    - `slope`: J^T r, (unknowns,) [1]; `size`, `way`: eigenvalues and -vectors of J^T J [1].
    """

    slope: Float[Array, " unknowns"]
    size: Float[Array, " unknowns"]
    way: Float[Array, "unknowns unknowns"]

    def damped(self, trust: Float[Array, ""] | float) -> Float[Array, " unknowns"]:
        """The Newton step [1] with damping 1/trust."""
        along = (self.slope @ self.way) / (jnp.maximum(self.size, 0) + 1 / trust)
        return -self.way @ along

    def within(self, most: Float[Array, ""], trust: Float[Array, ""]) -> Float[Array, " unknowns"]:
        """The step [1] with the least damping that changes no parameter by more than `most` [1].

        What the data know well goes all its way in it, while what they hardly know is held back.

        Source: Nocedal and Wright, Numerical Optimization, section 4.3, there of the length.
        """

        def halve(_: Any, ends: tuple[Array, Array]) -> tuple[Array, Array]:
            low, high = ends
            middle = 0.5 * (low + high)
            short = optx.max_norm(self.damped(jnp.exp(middle))) <= most
            return jnp.where(short, middle, low), jnp.where(short, high, middle)

        # No step is longer than the slope times the inverse of the damping.
        least = jnp.maximum(most, TINY) / jnp.maximum(jnp.linalg.norm(self.slope), TINY)
        ends = jnp.log(jnp.minimum(least, trust)), jnp.log(trust)
        return self.damped(jnp.exp(jax.lax.fori_loop(0, HALVINGS, halve, ends)[0]))

    def promise(self, move: Float[Array, " unknowns"]) -> Float[Array, ""]:
        """By how much the linearised residual lets the loss fall [1] in a step."""
        return -(self.slope @ move + 0.5 * jnp.sum(self.size * (move @ self.way) ** 2))

    def most(self) -> Float[Array, ""]:
        """The promise of the whole step [1], with the first damping and nothing cut."""
        return self.promise(self.damped(FIRST_STEP))


@final
class _BoundedDescent(optx.AbstractDescent):
    """A Newton step of bounded length: cut, or damped to it, whichever promises more."""

    def init(self, y: Any, f_info_struct: Any) -> Any:
        del f_info_struct
        return _Near(jnp.zeros_like(y), jnp.zeros_like(y), jnp.zeros((y.size, y.size)))

    def query(self, y: Any, f_info: Any, state: Any) -> Any:
        del y, state
        matrix = f_info.jac.as_matrix()
        return _Near(f_info.residual @ matrix, *jnp.linalg.eigh(matrix.T @ matrix))

    def step(self, step_size: Any, state: Any) -> Any:
        trust = jnp.minimum(step_size, FIRST_STEP)
        whole = state.damped(trust)
        most = _longest(whole, trust)
        cut, damped = jnp.clip(whole, -most, most), state.within(most, trust)
        better = jnp.where(state.promise(cut) > state.promise(damped), cut, damped)
        return better, optx.RESULTS.successful


# Compiled for what it keeps: the state holds the shape of a Jacobian as a program of its own, and a
# second fit of the same shapes must meet the same one, or every step would be traced anew.
@program
def _begin(objective: Objective, parameters: Parameters, solver: Any) -> Any:
    flat, _ = ravel_pytree(parameters)
    # Only shapes count here; tracing a whole run for them takes seconds.
    terms = jax.eval_shape(lambda: penalty(objective, parameters)).size
    count = sum(case.data.size for case in objective.cases) + terms
    function = _known(jnp.zeros(count), jnp.zeros((count, flat.size)))
    shape = jax.ShapeDtypeStruct((count,), flat.dtype)
    state = solver.init(function, flat, None, {}, shape, None, frozenset())
    # With a weak type here the second step would be compiled anew.
    first = jnp.asarray(FIRST_STEP, float)
    return eqx.tree_at(lambda s: s.search_state.step_size, state, first)


@program
def _advance(
    objective: Objective, parameters: Parameters, state: Any, solver: Any
) -> tuple[Parameters, Any, Float[Array, ""], Any]:
    flat, unravel = ravel_pytree(parameters)
    function = _known(*_dense(objective, unravel(state.y_eval)))
    before = state
    new, state, _ = solver.step(function, flat, None, {}, state, frozenset())
    # Trust never passes where it began, so that every refusal shortens the next step.
    trust = jnp.minimum(state.search_state.step_size, FIRST_STEP)
    state = eqx.tree_at(lambda s: s.search_state.step_size, state, trust)
    done, result = solver.terminate(function, new, None, {}, state, frozenset())
    loss = 0.5 * jnp.sum(state.f_info.residual**2)
    # The loss is half a chi-squared: a step that promises less than this moves no parameter by
    # more than a fraction of its own uncertainty. A step that is cut promises less than there is.
    least = jnp.maximum(objective.gain, objective.settled * loss)
    settled = state.descent_state.most() < least
    # The trial that comes next is close enough to need no run of its own.
    close = optx.max_norm(state.descent_state.damped(FIRST_STEP)) <= objective.near
    close = close & (state.num_steps_since_acceptance == 0)
    new, settled = jnp.where(close, state.y_eval, new), settled | close
    stalled = jnp.zeros_like(settled)
    if objective.tangents is not None:
        # What coarse tangents promise is not what they gain: a gain as small as that ends it too,
        # as long as the step was not shortened for lack of trust.
        gain = 0.5 * jnp.sum(before.f_info.residual**2) - loss
        little = least * before.search_state.step_size / FIRST_STEP
        settled = settled | (~before.first_step & (gain > 0) & (gain < little))
        stalled = state.num_steps_since_acceptance >= STALLED
    fine = (done & (result == optx.RESULTS.successful)) | settled
    return unravel(new), state, loss, (done | settled | stalled, fine)


@final
class LevenbergMarquardt(AbstractOptimiser):
    """Damped Gauss-Newton with the whole Jacobian: for up to some hundred unknowns.

    - `max_steps`: trial steps [1]; `rtol`: of parameters and residual at the end [1].

    Source: Nocedal and Wright, Numerical Optimization, section 10.3.
    """

    max_steps: int = 25
    rtol: float = 1e-4

    def _method(self) -> optx.LevenbergMarquardt:
        method = optx.LevenbergMarquardt(rtol=self.rtol, atol=self.rtol)
        return eqx.tree_at(lambda m: m.descent, method, _BoundedDescent())

    def begin(self, objective: Objective, parameters: Parameters) -> Any:
        """State before the first step, at the given parameters [1]."""
        return _begin(objective, parameters, self._method())

    def resume(self, state: Any, memory: Memory) -> Any:
        """The state with the damping that `memory` kept [1]."""
        # A fit that has accepted steps and yet stands at its first one was taken up again.
        step = jnp.asarray(memory["step_size"])
        accepted = jnp.asarray(memory["accepted"])
        return eqx.tree_at(
            lambda s: (s.search_state.step_size, s.num_accepted_steps), state, (step, accepted)
        )

    def fixed_length(self) -> bool:
        """No: it stops by its tolerance [1]."""
        return False

    def loss_at_arrival(self) -> bool:
        """Yes: the loss [1] belongs to the accepted parameters."""
        return True

    def residual(self, state: Any) -> Float[Array, " all"] | None:
        """The residual [1] of the accepted parameters."""
        return state.f_info.residual

    def memory(self, state: Any) -> Memory:
        """The damping and the number of accepted steps [1]."""
        return {
            "step_size": np.asarray(state.search_state.step_size),
            "accepted": np.asarray(state.num_accepted_steps),
        }

    def advance(
        self, objective: Objective, parameters: Parameters, state: Any
    ) -> tuple[Parameters, Any, Float[Array, ""], Any]:
        """One trial step [1]."""
        method = self._method()
        if bool(state.first_step) and int(state.num_accepted_steps) > 0:
            # The fit goes on: only the Jacobian where it stood is missing.
            parameters, state, _, _ = _advance(objective, parameters, state, method)
        return _advance(objective, parameters, state, method)


@final
class _Trial(eqx.Module):
    """Between two steps: trust `step` [1], `loss` [1] where the fit stands, a `trial` point [1].

    - `predicted`: change of the loss that the linearised residual promises there [1].
    """

    step: Float[Array, ""]
    loss: Float[Array, ""]
    trial: Float[Array, " unknowns"]
    predicted: Float[Array, ""]


@program
def _advance_krylov(
    objective: Objective, parameters: Parameters, state: _Trial, inner: lx.CG, rtol: float
) -> tuple[Parameters, _Trial, Float[Array, ""], Any]:
    stood, unravel = ravel_pytree(parameters)

    def function(point: Float[Array, " unknowns"]) -> Float[Array, " all"]:
        return residual(objective, unravel(point))

    change = 0.5 * jnp.sum(function(state.trial) ** 2) - state.loss
    begun = jnp.isfinite(state.loss)
    accept = ~begun | (change <= ACCEPTED * state.predicted)
    good = begun & (change < GOOD * state.predicted)
    step = state.step * jnp.where(accept, jnp.where(good, WIDEN, 1.0), NARROW)
    step = jnp.minimum(step, FIRST_STEP)
    flat = jnp.where(accept, state.trial, stood)

    value, pull = jax.vjp(function, flat)
    (slope,) = pull(value)

    def push(way: Float[Array, " unknowns"]) -> Float[Array, " all"]:
        return jax.jvp(function, (flat,), (way,))[1]

    damped = lx.FunctionLinearOperator(
        lambda way: pull(push(way))[0] + way / step,
        jax.eval_shape(lambda: flat),
        lx.positive_semidefinite_tag,
    )
    # Running out of iterations is no failure: what conjugate gradients have by then is still a
    # direction of descent, and the trust region judges it.
    whole = lx.linear_solve(damped, -slope, inner, throw=False).value
    move = _shortened(whole, step)
    part = optx.max_norm(move) / jnp.maximum(optx.max_norm(whole), 1e-12)
    along, across = slope @ whole, 0.5 * jnp.sum(push(whole) ** 2)
    loss = 0.5 * jnp.sum(value**2)
    predicted = part * along + part**2 * across
    moved = accept & begun
    settled = -(along + across) < jnp.maximum(objective.gain, objective.settled * loss)
    settled = settled | (moved & jnp.all(jnp.abs(flat - stood) < rtol * (1 + jnp.abs(flat))))
    return unravel(flat), _Trial(step, loss, flat + move, predicted), loss, (settled, settled)


@final
class GaussNewtonKrylov(AbstractOptimiser):
    """Damped Gauss-Newton by products with the Jacobian and its transpose: for large fields.

    - `max_steps`: trial steps [1]; `rtol`: of parameters and residual at the end [1].
    - `inner_steps`: conjugate-gradient iterations a step [1]; `inner_rtol`: their tolerance [1].

    Source: Nocedal and Wright, Numerical Optimization, section 7.1.
    """

    max_steps: int = 15
    rtol: float = 1e-4
    inner_steps: int = 20
    inner_rtol: float = 1e-2

    def begin(self, objective: Objective, parameters: Parameters) -> Any:
        """State before the first step, at the given parameters [1]."""
        del objective
        flat, _ = ravel_pytree(parameters)
        far = jnp.asarray(np.inf, float)
        return _Trial(jnp.asarray(FIRST_STEP, float), far, flat, jnp.asarray(0.0, float))

    def resume(self, state: Any, memory: Memory) -> Any:
        """The state that `memory` kept [1]."""
        del state
        return _Trial(**{name: jnp.asarray(value) for name, value in memory.items()})

    def fixed_length(self) -> bool:
        """No: it stops by its tolerance [1]."""
        return False

    def loss_at_arrival(self) -> bool:
        """Yes: the loss [1] belongs to the accepted parameters."""
        return True

    def residual(self, state: Any) -> Float[Array, " all"] | None:
        """None: products with the Jacobian need not keep it [1]."""
        del state

    def memory(self, state: Any) -> Memory:
        """The damping, the loss and the trial point [1]."""
        names = ("step", "loss", "trial", "predicted")
        return {name: np.asarray(getattr(state, name)) for name in names}

    def advance(
        self, objective: Objective, parameters: Parameters, state: Any
    ) -> tuple[Parameters, Any, Float[Array, ""], Any]:
        """One trial step [1]."""
        inner = lx.CG(rtol=self.inner_rtol, atol=0.0, max_steps=self.inner_steps)
        return _advance_krylov(objective, parameters, state, inner, self.rtol)
