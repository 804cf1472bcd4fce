"""What a simulation was at between its frames."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int


def between_frames(
    temperature: Float[Array, "frames samples"],
    time: Float[Array, " frames"],
    at: Float[Array, " times"],
) -> Float[Array, "times samples"]:
    """Temperatures [K] at any times [s], by cubics from frame to frame in the root of time.

    After a lamp is lit, or surroundings change, a skin goes with powers of (t - t_0)^1/2, which
    lines between frames miss by far more than noise just then. Before the first frame all is as
    there; after the last it goes on along a line. Two frames at the least.

    A run that others outlast is filled up with its last time; what stands there is not read.

    Source: de Boor, A Practical Guide to Splines (2001), chapter 4, Bessel's slopes; Carslaw and
    Jaeger, Conduction of Heat in Solids, section 2.4, for the root.
    """
    end = jnp.sum(jnp.diff(time) > 0)
    own = jnp.minimum(jnp.arange(len(time)), end)
    temperature, time = temperature[own], jax.lax.stop_gradient(time[own])
    root = _root(time - time[0])
    place = _root(jnp.minimum(at, time[end]) - time[0])
    left = jnp.clip(jnp.searchsorted(root, place, side="right") - 1, 0, end - 1)
    gap = (root[left + 1] - root[left])[:, None]
    share = (place - root[left])[:, None] / gap
    slopes = _slopes(temperature, root, end)
    rise = temperature[left + 1] - temperature[left]
    ahead, back = gap * slopes[left] - rise, gap * slopes[left + 1] - rise
    bend = share * (1 - share) * ((1 - share) * ahead - share * back)
    last = (temperature[end] - temperature[end - 1]) / (time[end] - time[end - 1])
    beyond = jnp.maximum(at - time[end], 0.0)[:, None] * last
    return temperature[left] + share * rise + bend + beyond


def _slopes(
    temperature: Float[Array, "frames samples"], root: Float[Array, " frames"], end: Int[Array, ""]
) -> Float[Array, "frames samples"]:
    """Slopes [K/s^1/2] at frames, of the parabola through each and its neighbours."""
    gap = jnp.diff(root, append=root[-1:])
    known = gap[:, None] > 0
    rate = jnp.diff(temperature, axis=0, append=temperature[-1:]) / jnp.where(
        known, gap[:, None], 1.0
    )
    both = gap + jnp.roll(gap, 1)
    mixed = gap[:, None] * jnp.roll(rate, 1, axis=0) + jnp.roll(gap, 1)[:, None] * rate
    inside = mixed / jnp.where(both > 0, both, 1.0)[:, None]

    def outer(one: Int[Array, ""], other: Int[Array, ""]) -> Float[Array, " samples"]:
        bent = gap[one] * (rate[one] - rate[other]) / (gap[one] + gap[other])
        return rate[one] + jnp.where(end > 1, bent, 0.0)

    first, second = jnp.zeros_like(end), jnp.minimum(1, end - 1)
    made = inside.at[0].set(outer(first, second))
    return made.at[end].set(outer(end - 1, jnp.maximum(end - 2, 0)))


def _root(time: Float[Array, " times"]) -> Float[Array, " times"]:
    """Roots of times [s], those before the start as at the start, with slope zero."""
    after = time > 0
    return jnp.where(after, jnp.sqrt(jnp.where(after, time, 1.0)), 0.0)
