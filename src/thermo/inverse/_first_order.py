"""L-BFGS and Adam, on the gradient alone."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any, cast, final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
import optimistix as optx
from jaxtyping import Array, Float

from thermo._compiled import program
from thermo.inverse._objective import Objective, Parameters, residual
from thermo.inverse._optimiser import AbstractOptimiser, Memory


def loss(objective: Objective, parameters: Parameters) -> Float[Array, ""]:
    """Half the sum of squares of the whitened residual [1]."""
    return 0.5 * jnp.sum(residual(objective, parameters) ** 2)


def _leaves(state: Any) -> Memory:
    arrays = jax.tree.leaves(eqx.filter(state, eqx.is_array))
    return {f"leaf_{number:03d}": np.asarray(leaf) for number, leaf in enumerate(arrays)}


def _refill(state: Any, memory: Memory) -> Any:
    arrays, rest = eqx.partition(state, eqx.is_array)
    old, shape = jax.tree.flatten(arrays)
    new = [jnp.asarray(memory[f"leaf_{number:03d}"]) for number in range(len(old))]
    return eqx.combine(jax.tree.unflatten(shape, new), rest)


@final
class LimitedMemoryBfgs(AbstractOptimiser):
    """L-BFGS with backtracking.

    - `max_steps`: trial steps [1]; `rtol`: of parameters and loss at the end [1].

    Source: Nocedal and Wright, Numerical Optimization, section 7.2.
    """

    max_steps: int = 60
    rtol: float = 1e-5

    def _method(self) -> optx.LBFGS:
        return optx.LBFGS(rtol=self.rtol, atol=self.rtol)

    def begin(self, objective: Objective, parameters: Parameters) -> Any:
        """State before the first step, at the given parameters [1]."""
        scale = _residuals(objective, parameters)
        function = _scaled(objective, scale)
        shape = jax.ShapeDtypeStruct((), jnp.asarray(0.0).dtype)
        inner = self._method().init(function, parameters, None, {}, shape, None, frozenset())
        return inner, jnp.asarray(scale)

    def resume(self, state: Any, memory: Memory) -> Any:
        """The state with everything that `memory` kept [1]."""
        return _refill(state, memory)

    def fixed_length(self) -> bool:
        """No: it stops by its tolerance [1]."""
        return False

    def loss_at_arrival(self) -> bool:
        """Yes: the loss [1] belongs to the accepted parameters."""
        return True

    def residual(self, state: Any) -> Float[Array, " all"] | None:
        """None: the state holds the loss only [1]."""
        del state

    def memory(self, state: Any) -> Memory:
        """The whole state [1]: some vectors as long as the parameters."""
        return _leaves(state)

    def advance(
        self, objective: Objective, parameters: Parameters, state: Any
    ) -> tuple[Parameters, Any, Float[Array, ""], Any]:
        """One trial step [1]."""
        inner, scale = state
        new, inner, value, done = _advance_lbfgs(
            objective, parameters, inner, scale, self._method()
        )
        return new, (inner, scale), value, done


def _residuals(objective: Objective, parameters: Parameters) -> float:
    """Number of residuals [1]; the loss is divided by it so that its slope is of order one."""
    return float(jax.eval_shape(lambda p: residual(objective, p), parameters).shape[0])


def _scaled(objective: Objective, scale: Any) -> Any:
    def function(parameters: Parameters, args: Any) -> tuple[Float[Array, ""], None]:
        del args
        return loss(objective, parameters) / scale, None

    return function


@program
def _advance_lbfgs(
    objective: Objective, parameters: Parameters, state: Any, scale: Any, method: Any
) -> tuple[Parameters, Any, Float[Array, ""], Any]:
    function = _scaled(objective, scale)
    new, state, _ = method.step(function, parameters, None, {}, state, frozenset())
    done, result = method.terminate(function, new, None, {}, state, frozenset())
    return new, state, state.f_info.f * scale, (done, result == optx.RESULTS.successful)


@final
class Adam(AbstractOptimiser):
    """Adam with a learning rate for each field.

    - `max_steps`: epochs [1].
    - `rate`: learning rate [1]; `rates`: other rates by quantity name.

    Source: paper, appendix B.8 (checklist E3, E4).
    """

    max_steps: int = 200
    rate: float = 0.05
    rates: Mapping[str, float] = eqx.field(default_factory=dict)

    def _method(self, names: tuple[str, ...]) -> optax.GradientTransformation:
        each: dict[Hashable, optax.GradientTransformation] = {
            name: optax.adam(self.rates.get(name, self.rate)) for name in names
        }
        return optax.partition(each, lambda tree: {name: name for name in tree})

    def begin(self, objective: Objective, parameters: Parameters) -> Any:
        """State before the first step, at the given parameters [1]."""
        return self._method(tuple(parameters)).init(parameters)

    def resume(self, state: Any, memory: Memory) -> Any:
        """The state with everything that `memory` kept [1]."""
        return _refill(state, memory)

    def fixed_length(self) -> bool:
        """Yes: it makes all its epochs [1]."""
        return True

    def loss_at_arrival(self) -> bool:
        """No: the loss [1] is that before the step."""
        return False

    def residual(self, state: Any) -> Float[Array, " all"] | None:
        """None: the state holds the loss only [1]."""
        del state

    def memory(self, state: Any) -> Memory:
        """The moments [1]."""
        return _leaves(state)

    def advance(
        self, objective: Objective, parameters: Parameters, state: Any
    ) -> tuple[Parameters, Any, Float[Array, ""], Any]:
        """One epoch over all runs [1]; the loss is that before the step."""
        value, slope = _slope(objective, parameters)
        updates, state = self._method(tuple(parameters)).update(slope, state, parameters)
        new = cast(Parameters, optax.apply_updates(parameters, updates))
        return new, state, value, (False, True)


@program
def _slope(objective: Objective, parameters: Parameters) -> tuple[Float[Array, ""], Parameters]:
    count = _residuals(objective, parameters)
    value, slope = jax.value_and_grad(lambda p: loss(objective, p) / count)(parameters)
    return value * count, slope
