"""Conjugate gradients with the diagonal as preconditioner, for one or many right-hand sides."""

from __future__ import annotations

from typing import Any, final

import jax
import jax.numpy as jnp
import lineax as lx
from jax.custom_batching import custom_vmap
from jaxtyping import Array, Bool, Float, Int

from thermo.physics._pattern import Pattern, row_product, split_rows
from thermo.physics._sparse_operator import SparseOperator

_State = tuple[Pattern, Float[Array, " nodes"], Float[Array, " entries"]]


def _dot(
    a: Float[Array, "nodes *batch"], b: Float[Array, "nodes *batch"]
) -> Float[Array, "*batch"]:
    return jnp.sum(a * b, axis=0)


def _iterate(
    state: _State,
    rhs: Float[Array, "nodes *batch"],
    goal: Float[Array, "*batch"],
    max_steps: int,
) -> tuple[Float[Array, "nodes *batch"], Int[Array, ""], Bool[Array, ""]]:
    """Solve for all columns of `rhs` together; a column that has met its goal stands still."""
    pattern, diagonal, rows = state
    pieces = split_rows(pattern, rows)
    inverse = (1 / diagonal).reshape(-1, *(1,) * (rhs.ndim - 1))
    z = inverse * rhs
    rz = _dot(rhs, z)

    def unfinished(carry: Any) -> Bool[Array, ""]:
        *_, rz, step = carry
        return jnp.any(rz > goal) & (step < max_steps)

    def body(carry: Any) -> Any:
        x, r, p, rz, step = carry
        q = row_product(pattern, diagonal, pieces, p)
        curvature = _dot(p, q)
        alpha = jnp.where(rz > goal, rz / jnp.where(curvature == 0, 1, curvature), 0)
        x, r = x + alpha * p, r - alpha * q
        z = inverse * r
        new = _dot(r, z)
        return x, r, z + (new / jnp.where(rz == 0, 1, rz)) * p, new, step + 1

    start = (jnp.zeros_like(rhs), rhs, z, rz, jnp.zeros((), jnp.int32))
    x, _, _, rz, steps = jax.lax.while_loop(unfinished, body, start)
    return x, steps, jnp.all(rz <= goal)


@final
class ConjugateGradient(lx.AbstractLinearSolver[_State]):
    """Solve A x = b until the residual has fallen by `rtol` in the norm of the inverse diagonal.

    Simulations solve for the increment of temperature over a step, so that `rtol` is the error
    of a step relative to its own change in kelvin, whatever the level of temperature, and a body
    that warms by 10 K keeps an error of about 10 K times `rtol`. Batches made by `jax.vmap` over
    right-hand sides run together, laid out (nodes, batch). The option `y0` is a first guess [K]:
    it changes the number of iterations, not what the tolerance is relative to.

    - `rtol`: [1].
    - `max_steps`: the most iterations [1]; reaching it is reported as a failure.

    Source: Saad, Iterative Methods for Sparse Linear Systems, algorithm 9.1.
    """

    rtol: float = 1e-7
    max_steps: int = 2000

    def init(self, operator: Any, options: dict[str, Any]) -> _State:
        """Nothing to prepare but the padded rows."""
        del options
        if not isinstance(operator, SparseOperator):
            raise TypeError(f"ConjugateGradient solves SparseOperator, not {type(operator)}")
        return operator.pattern, operator.diagonal, operator.rows

    def compute(
        self, state: _State, vector: Float[Array, " nodes"], options: dict[str, Any]
    ) -> tuple[Float[Array, " nodes"], Any, dict[str, Any]]:
        """Solution [K] for a right-hand side [J]."""

        @custom_vmap
        def solve(state: _State, rhs: Any, goal: Any) -> Any:
            return _iterate(state, rhs, goal, self.max_steps)

        @solve.def_vmap
        def together(size: int, batched: Any, state: _State, rhs: Any, goal: Any) -> Any:
            if any(jax.tree.leaves(batched[0])) or not (batched[1] and batched[2]):
                axes = jax.tree.map(lambda flag: 0 if flag else None, batched)
                each = jax.vmap(
                    lambda s, b, g: _iterate(s, b, g, self.max_steps), in_axes=tuple(axes)
                )
                return each(state, rhs, goal), (True, True, True)
            x, steps, done = _iterate(state, rhs.T, goal, self.max_steps)
            spread = jnp.full(size, steps), jnp.full(size, done)
            return (x.T, *spread), (True, True, True)

        pattern, diagonal, rows = state
        goal = self.rtol**2 * _dot(vector, vector / diagonal)
        guess = options.get("y0")
        if guess is not None:
            pieces = split_rows(pattern, rows)
            vector = vector - row_product(pattern, diagonal, pieces, guess)
        x, steps, done = solve(state, vector, goal)
        if guess is not None:
            x = x + guess
        result = lx.RESULTS.where(done, lx.RESULTS.successful, lx.RESULTS.max_steps_reached)
        return x, result, {"num_steps": steps, "max_steps": self.max_steps}

    def transpose(self, state: _State, options: dict[str, Any]) -> tuple[_State, dict[str, Any]]:
        """The operator is symmetric."""
        return state, options

    def conj(self, state: _State, options: dict[str, Any]) -> tuple[_State, dict[str, Any]]:
        """The operator is real."""
        return state, options

    def assume_full_rank(self) -> bool:
        """Yes: the mass matrix makes every step positive definite."""
        return True
