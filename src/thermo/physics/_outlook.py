"""How earlier steps point to the solution of the next, and later ones to that of the adjoint."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

DEPTH = 3
"""Steps [1] that are looked back at."""

AHEAD, BACK = 2, 3
"""Of these, how many temperatures and how many adjoints are carried on [1].

On a cooling sphere of 12 000 nodes two and three take the fewest iterations for a given error: an
adjoint is needed to fewer digits, so that a higher degree has less rounding to carry on.
"""

MOST = 15.0
"""Sum of the weights' sizes [1] above which steps of unlike length are looked back at less far."""


@final
class Outlook(eqx.Module):
    """How the past of a step points to its solution.

    - `ahead`: what to multiply the rate of each earlier step with, (depth,) [1].
    - `back`: the same for the adjoint, which comes from the later steps, (depth,) [1].
    - `size`: of the step [s].
    - `place`: where the step's own solution goes, in place of the oldest one.
    """

    ahead: Float[Array, "*steps depth"]
    back: Float[Array, "*steps depth"]
    size: Float[Array, "*steps"]
    place: Int[Array, "*steps"]


@final
class Memory(eqx.Module):
    """What the linear solves of a step hand on, each to the same one of the next step.

    - `found`: the solutions of the last steps, over their lengths, each at its place,
      (solves, depth, nodes) [K/s]; in single precision, since a solve only begins there.
    - `largest`: of tangents and adjoints the largest right-hand side so far, squared in the norm
      of the inverse diagonal, (solves,); zero for temperatures.
    """

    found: Float[Array, "solves depth nodes"]
    largest: Float[Array, " solves"]


def without_past(solves: int, nodes: int) -> tuple[Memory, Outlook]:
    """The past and the outlook of a step with no other before it."""
    nothing = jnp.zeros(DEPTH)
    past = Memory(jnp.zeros((solves, DEPTH, nodes), jnp.float32), jnp.zeros(solves))
    return past, Outlook(nothing, nothing, jnp.ones(()), jnp.zeros((), jnp.int32))


def _extrapolation(time: Float[Array, " steps"], count: int) -> Float[Array, "steps depth"]:
    """Weights [1] of up to `count` earlier values at times [s], by the polynomial through them."""
    number, nearest = np.arange(len(time))[:, None], np.arange(DEPTH)
    # The times of the earlier steps, beside each step's own.
    known = time[(number - 1 - nearest) % len(time)]
    apart = known[:, :, None] - known[:, None, :]
    ratio = (time[:, None] - known)[:, None, :] / jnp.where(apart == 0, 1.0, apart)
    ratio = jnp.where(apart == 0, jnp.inf, ratio)
    ratio = jnp.where(np.eye(DEPTH, dtype=bool), 1.0, ratio)
    best, product = jnp.zeros((len(time), DEPTH)), jnp.ones((len(time), DEPTH))
    for points in range(1, count + 1):
        product = product * ratio[:, :, points - 1]
        weights = jnp.where(nearest < points, product, 0.0)
        sound = (number >= points) & (jnp.sum(jnp.abs(weights), 1, keepdims=True) <= MOST)
        best = jnp.where(sound, weights, best)
    return best


def outlooks(start: Float[Array, " steps"], size: Float[Array, " steps"]) -> Outlook:
    """The outlook of every step, from its start and length [s].

    Temperatures are carried on as rates at the middle of a step, adjoints as they are.
    """
    middle = start + 0.5 * size
    number = jnp.arange(len(middle))[:, None]
    nearest = jnp.arange(DEPTH)
    ahead = _extrapolation(middle, AHEAD)
    back = _extrapolation(-middle[::-1], BACK)[::-1]
    # Weights are listed from the nearest step on, solutions by the number of their step.
    ahead = jnp.take_along_axis(ahead, (number - 1 - nearest) % DEPTH, axis=1)
    back = jnp.take_along_axis(back, (nearest - number - 1) % DEPTH, axis=1)
    return Outlook(ahead, back, size, number[:, 0] % DEPTH)
