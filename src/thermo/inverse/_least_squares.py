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

from thermo.inverse._objective import Objective, Parameters, jacobian, residual
from thermo.inverse._optimiser import AbstractOptimiser, Memory

# The first damping is light: the parameters are logarithms, of order one, and whitened residuals
# make the Gauss-Newton step a good one from the start.
FIRST_STEP = 1e2


def _dense_residual(objective: Objective, unravel: Any) -> Any:
    """Residual whose derivative is made densely, all directions at once."""

    @jax.custom_jvp
    def function(flat: Float[Array, " unknowns"]) -> Float[Array, " all"]:
        return residual(objective, unravel(flat))

    @function.defjvp
    def _(point: Any, tangent: Any) -> Any:
        value, matrix = jacobian(objective, unravel(point[0]))
        return value, matrix @ tangent[0]

    return function


def _solver(linear: lx.AbstractLinearSolver, rtol: float) -> optx.LevenbergMarquardt:
    return optx.LevenbergMarquardt(rtol=rtol, atol=rtol, linear_solver=linear)


def _prepare(
    objective: Objective, parameters: Parameters, solver: Any, *, dense: bool
) -> tuple[Any, Float[Array, " unknowns"], Any]:
    flat, unravel = ravel_pytree(parameters)
    if dense:
        plain = _dense_residual(objective, unravel)
    else:

        def plain(point: Float[Array, " unknowns"]) -> Float[Array, " all"]:
            return residual(objective, unravel(point))

    def function(point: Any, args: Any) -> tuple[Any, None]:
        del args
        return plain(point), None

    return function, flat, unravel


def _begin(objective: Objective, parameters: Parameters, solver: Any, *, dense: bool) -> Any:
    function, flat, _ = _prepare(objective, parameters, solver, dense=dense)
    shape = jax.eval_shape(lambda point: function(point, None)[0], flat)
    state = solver.init(function, flat, None, {}, shape, None, frozenset())
    return eqx.tree_at(lambda s: s.search_state.step_size, state, jnp.asarray(FIRST_STEP))


@eqx.filter_jit
def _advance(
    objective: Objective, parameters: Parameters, state: Any, solver: Any, dense: bool
) -> tuple[Parameters, Any, Float[Array, ""], Any]:
    function, flat, unravel = _prepare(objective, parameters, solver, dense=dense)
    new, state, _ = solver.step(function, flat, None, {}, state, frozenset())
    done, result = solver.terminate(function, new, None, {}, state, frozenset())
    loss = 0.5 * jnp.sum(state.f_info.residual**2)
    return unravel(new), state, loss, (done, result == optx.RESULTS.successful)


def _memory(state: Any) -> Memory:
    return {"step_size": np.asarray(state.search_state.step_size)}


def _resume(state: Any, memory: Memory) -> Any:
    step = jnp.asarray(memory["step_size"])
    return eqx.tree_at(lambda s: s.search_state.step_size, state, step)


@final
class LevenbergMarquardt(AbstractOptimiser):
    """Damped Gauss-Newton with the whole Jacobian: for up to some hundred unknowns.

    - `max_steps`: trial steps [1]; `rtol`: of parameters and residual at the end [1].

    Source: Nocedal and Wright, Numerical Optimization, section 10.3.
    """

    max_steps: int = 25
    rtol: float = 1e-4

    def _method(self) -> optx.LevenbergMarquardt:
        return _solver(lx.Normal(lx.Cholesky()), self.rtol)

    def begin(self, objective: Objective, parameters: Parameters) -> Any:
        """State before the first step, at the given parameters [1]."""
        return _begin(objective, parameters, self._method(), dense=True)

    def resume(self, state: Any, memory: Memory) -> Any:
        """The state with the damping that `memory` kept [1]."""
        return _resume(state, memory)

    def fixed_length(self) -> bool:
        """No: it stops by its tolerance [1]."""
        return False

    def loss_at_arrival(self) -> bool:
        """Yes: the loss [1] belongs to the accepted parameters."""
        return True

    def memory(self, state: Any) -> Memory:
        """The damping [1]."""
        return _memory(state)

    def advance(
        self, objective: Objective, parameters: Parameters, state: Any
    ) -> tuple[Parameters, Any, Float[Array, ""], Any]:
        """One trial step [1]."""
        return _advance(objective, parameters, state, self._method(), True)


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

    def _method(self) -> optx.LevenbergMarquardt:
        # A Krylov method that stops at its last iteration still gives a descent direction, so
        # running out of them is no failure; the trust region judges the step.
        inner = lx.CG(rtol=self.inner_rtol, atol=0.0, max_steps=self.inner_steps)
        return _solver(lx.Normal(inner), self.rtol)

    def begin(self, objective: Objective, parameters: Parameters) -> Any:
        """State before the first step, at the given parameters [1]."""
        return _begin(objective, parameters, self._method(), dense=False)

    def resume(self, state: Any, memory: Memory) -> Any:
        """The state with the damping that `memory` kept [1]."""
        return _resume(state, memory)

    def fixed_length(self) -> bool:
        """No: it stops by its tolerance [1]."""
        return False

    def loss_at_arrival(self) -> bool:
        """Yes: the loss [1] belongs to the accepted parameters."""
        return True

    def memory(self, state: Any) -> Memory:
        """The damping [1]."""
        return _memory(state)

    def advance(
        self, objective: Objective, parameters: Parameters, state: Any
    ) -> tuple[Parameters, Any, Float[Array, ""], Any]:
        """One trial step [1]."""
        return _advance(objective, parameters, state, self._method(), False)
