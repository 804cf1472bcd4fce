"""Conjugate gradients with the diagonal as preconditioner, for one or many right-hand sides."""

from __future__ import annotations

from typing import Any, final

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from thermo.physics._step_matrix import StepMatrix


def _dot(
    a: Float[Array, "nodes *batch"], b: Float[Array, "nodes *batch"]
) -> Float[Array, "*batch"]:
    return jnp.sum(a * b, axis=0)


def _over(above: Float[Array, "*batch"], below: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """A quotient, zero where there is nothing to divide by."""
    return jnp.where(below > 0, above / jnp.where(below > 0, below, 1.0), 0.0)


SINGLE = 1e-6
"""Tolerance [1] from which single precision has digits enough."""


@final
class ConjugateGradient(eqx.Module):
    """Solve A x = b until the residual is `rtol` of b in the norm of the inverse diagonal.

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

        def unfinished(carry: Any) -> Bool[Array, ""]:
            *_, rz, step = carry
            # The first iteration moves along the guess: one product is written out, not two.
            return (step < 0) | (jnp.any(rz > goal) & (step < self.max_steps))

        def body(carry: Any) -> Any:
            x, r, p, rz, step = carry
            q = matrix.mv(p)
            # A column that has met its goal stands still.
            alpha = jnp.where((step < 0) | (rz > goal), _over(_dot(p, r), _dot(p, q)), 0.0)
            x, r = x + alpha * p, r - alpha * q
            z = inverse * r
            new = _dot(r, z)
            beta = jnp.where(step < 0, 0.0, _over(new, rz))
            return x, r, z + beta * p, new, step + 1

        start = (jnp.zeros_like(heat), heat, guess, whole, jnp.full((), -1, jnp.int32))
        x, _, _, rz, steps = jax.lax.while_loop(unfinished, body, start)
        return x, jnp.all(rz <= goal), steps

    def solve_in_single(
        self,
        matrix: StepMatrix,
        heat: Float[Array, "nodes batch"],
        guess: Float[Array, "nodes batch"],
        least: Float[Array, " batch"],
    ) -> tuple[Float[Array, "nodes batch"], Bool[Array, ""], Int[Array, ""]]:
        """The same for many right-hand sides, in single precision where `rtol` leaves room for it.

        They are bound by memory, so that this takes half the time.
        """
        if self.rtol < SINGLE:
            return self.solve(matrix, heat, guess, least)
        # Squares of what is far from one would leave the range.
        size = jnp.sqrt(jnp.where(least > 0, least, 1.0))
        scaled = (matrix, heat / size, guess / size, least / size**2)
        found, fine, steps = self.solve(*jax.tree.map(_single, scaled))
        return found * size, fine, steps


def _single(value: Any) -> Any:
    return value.astype(jnp.float32) if eqx.is_inexact_array(value) else value
