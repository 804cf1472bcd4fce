"""Preconditioned conjugate gradients, for one or many right-hand sides."""

from __future__ import annotations

from typing import Any, final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from thermo.physics._step_matrix import StepMatrix


def _dot(
    a: Float[Array, "nodes *batch"], b: Float[Array, "nodes *batch"]
) -> Float[Array, "*batch"]:
    return jnp.sum(a * b, axis=0)


def _over(above: Float[Array, "*batch"], below: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """A quotient, zero where there is nothing to divide by."""
    return jnp.where(below > 0, above / jnp.where(below > 0, below, 1.0), 0.0)


def _preconditioned(
    matrix: StepMatrix,
    inverse: Float[Array, "nodes *one"],
    residual: Float[Array, "nodes *batch"],
) -> tuple[Float[Array, "nodes *batch"], Float[Array, "*batch"], Float[Array, "*batch"]]:
    """What the preconditioner makes of a residual, their product, and the residual's squared norm.

    The norm is that of the `inverse` diagonal alone [K/J], whatever the preconditioner.
    """
    found = inverse * residual
    size = _dot(residual, found)
    if matrix.coarse is None:
        return found, size, size
    smooth = matrix.coarse.apply(residual)
    return found + smooth, size + _dot(residual, smooth), size


SINGLE = 1e-6
"""Tolerance [1] from which single precision has digits enough for a right-hand side."""

ROUNDING = 8 * float(np.finfo(np.float32).eps)
"""Residual [1] that rounding may leave, over the solution, both in the norm of the diagonal.

Twice of what it was at most, over right-hand sides from rough to constant, steps of 0.1 to
100 s and 12 000 to 95 000 nodes of aluminium (`benchmarks/rounding.py`).
"""

DEEPEST, MOST_PASSES = 1e-5, 10
"""Reduction of the residual [1] in one pass of single precision, and the most passes [1]."""


@final
class ConjugateGradient(eqx.Module):
    """Solve A x = b until the residual is `rtol` of b in the norm of the inverse diagonal.

    The preconditioner is that diagonal, with a correction in coarser spaces where it pays.

    Simulations solve for the increment of temperature over a step, so that `rtol` is the error
    of a step relative to its own change in kelvin, whatever the level of temperature, and a body
    that warms by 10 K keeps an error of about 10 K times `rtol`. Many right-hand sides, laid out
    (nodes, batch), run together.

    - `rtol`: [1].
    - `max_steps`: the most iterations [1]; reaching it is reported as a failure.

    Source: Saad, Iterative Methods for Sparse Linear Systems, algorithm 9.1.
    """

    rtol: float = eqx.field(static=True, default=1e-7)
    max_steps: int = eqx.field(static=True, default=2000)

    def solve(
        self,
        matrix: StepMatrix,
        heat: Float[Array, "nodes *batch"],
        guess: Float[Array, "nodes *batch"],
        least: Float[Array, "*batch"] | float = 0.0,
    ) -> tuple[Float[Array, "nodes *batch"], Bool[Array, ""], Int[Array, ""]]:
        """Solution [K] for right-hand sides [J] from a guess [K], whether it was found, iterations.

        The best multiple of the guess is where the iterations begin: a bad one does no harm.
        A right-hand side whose squared norm is below `least` is solved as if it were that large.
        """
        inverse = (1 / matrix.diagonal).reshape(-1, *(1,) * (heat.ndim - 1))
        whole = _dot(heat, inverse * heat)
        goal = self.rtol**2 * jnp.maximum(whole, least)

        # The first iteration moves along the guess: one product is written out, not two.
        start = (jnp.zeros_like(heat), heat, guess, whole, whole, jnp.full((), -1, jnp.int32))
        x, left, steps = self._iterate(matrix, goal, start)
        return x, jnp.all(left <= goal), steps

    def _iterate(self, matrix: StepMatrix, goal: Array, start: Any) -> tuple[Array, Array, Array]:
        """Solution, squared norm of the residual and iterations.

        It starts from a solution, its residual, a direction, the residual's product with what the
        preconditioner makes of it, its squared norm, and the number of iterations done, which is -1
        where the direction is a guess.
        """
        inverse = (1 / matrix.diagonal).reshape(-1, *(1,) * (start[0].ndim - 1))

        def unfinished(carry: Any) -> Bool[Array, ""]:
            *_, left, step = carry
            return (step < 0) | (jnp.any(left > goal) & (step < self.max_steps))

        def body(carry: Any) -> Any:
            x, r, p, rz, left, step = carry
            q = matrix.mv(p)
            # A column that has met its goal stands still.
            alpha = jnp.where((step < 0) | (left > goal), _over(_dot(p, r), _dot(p, q)), 0.0)
            x, r = x + alpha * p, r - alpha * q
            z, new, left = _preconditioned(matrix, inverse, r)
            beta = jnp.where(step < 0, 0.0, _over(new, rz))
            return x, r, z + beta * p, new, left, step + 1

        x, _, _, _, left, steps = jax.lax.while_loop(unfinished, body, start)
        return x, left, steps

    def solve_together(
        self,
        matrix: StepMatrix,
        heat: Float[Array, "nodes batch"],
        guess: Float[Array, "nodes batch"],
        least: Float[Array, " batch"],
    ) -> tuple[Float[Array, "nodes batch"], Bool[Array, ""], Int[Array, ""]]:
        """The same for many right-hand sides, which are bound by memory: half as wide numbers.

        What a residual in double precision still asks for is found in single precision, until
        the rounding of what was found is below the tolerance: once, as a rule.

        Source: Higham, Accuracy and Stability of Numerical Algorithms, chapter 12.
        """
        diagonal = matrix.diagonal[:, None]
        goal = self.rtol**2 * jnp.maximum(_dot(heat, heat / diagonal), least)
        narrow = jax.tree.map(_single, matrix)

        def unfinished(carry: Any) -> Bool[Array, ""]:
            *_, left, steps, passes = carry
            return jnp.any(left > goal) & (steps < self.max_steps) & (passes < MOST_PASSES)

        def body(carry: Any) -> Any:
            x, r, way, _, _, steps, passes = carry
            image = matrix.mv(way)
            share = _over(_dot(way, r), _dot(way, image))
            x, r = x + share * way, r - share * image
            size = _dot(r, r / diagonal)
            # Squares of what is far from one would leave the range.
            scale = jnp.sqrt(jnp.where(size > 0, size, 1.0))
            b = _single(r / scale)
            first = _preconditioned(narrow, 1 / narrow.diagonal[:, None], b)
            start = (jnp.zeros_like(b), b, *first, jnp.zeros((), jnp.int32))
            wanted = _single(jnp.maximum(goal / scale**2, DEEPEST**2))
            way, left, count = self._iterate(narrow, wanted, start)
            # Both what the iterations left and what their rounding may hide.
            left = jnp.maximum(left, ROUNDING**2 * _dot(way, narrow.diagonal[:, None] * way))
            left = jnp.where(size > goal, scale**2 * left, 0.0)
            return x, r, way, scale, left, steps + count, passes + 1

        none, far = jnp.zeros((), jnp.int32), jnp.full_like(goal, jnp.inf)
        start = (jnp.zeros_like(heat), heat, _single(guess), jnp.ones_like(goal), far, none, none)
        x, _, way, scale, left, steps, _ = jax.lax.while_loop(unfinished, body, start)
        return x + scale * way, jnp.all(left <= goal), steps


def _single(value: Any) -> Any:
    return value.astype(jnp.float32) if eqx.is_inexact_array(value) else value
