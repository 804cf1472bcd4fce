"""How much of each face lies below a level, and on which side of the face."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

# Of linear functions on a triangle of area one the mass matrix is (1 + i = j) / 12: its inverse.
_OWN, _ALL = 12.0, 3.0


def covered(
    height: Float[Array, "faces corners sides"], depth: Float[Array, " sides"]
) -> Float[Array, "faces corners sides"]:
    """The share of a face that lies less than `depth` [m] high, as a linear function on it [1].

    Of `height` [m], linear on each face, the values at its three corners are given. The function's
    integral and its first moments over the face are those of what is covered, however small the
    depth is beside the face; it changes smoothly with the depth. Given at the corners.

    Source: Ciarlet, The Finite Element Method for Elliptic Problems (1978), section 3.1, the
    projection on linear functions.
    """
    order = jnp.argsort(height, axis=1)
    low, middle, high = jnp.moveaxis(jnp.take_along_axis(height, order, 1), 1, 0)
    # Cut off by the level: a triangle at the lowest corner, or all but one at the highest.
    first = _cut(depth - low, middle - low, high - low)
    last = _cut(high - depth, high - middle, high - low)
    at_low, at_high = jnp.stack(first, 1), 1 / 3 - jnp.stack(last[::-1], 1)
    moments = _choose(depth <= low, 0.0, _choose(depth <= middle, at_low, at_high))
    moments = _choose(depth >= high, 1 / 3, moments)
    moments = jnp.take_along_axis(moments, jnp.argsort(order, axis=1), 1)
    return _OWN * moments - _ALL * moments.sum(1, keepdims=True)


def _cut(
    reach: Float[Array, "faces sides"],
    near: Float[Array, "faces sides"],
    far: Float[Array, "faces sides"],
) -> tuple[Float[Array, "faces sides"], ...]:
    """First moments by its corners of the triangle that a level cuts off at a corner [1].

    `reach`: from the corner to the level; `near`, `far`: to the other two corners [m].
    """
    one, other = (reach / jnp.where(way > 0, way, 1.0) for way in (near, far))
    share = one * other
    return share * (1 - (one + other) / 3), share * one / 3, share * other / 3


def _choose(
    where: Bool[Array, "faces sides"],
    this: Float[Array, "faces 3 sides"] | float,
    that: Float[Array, "faces 3 sides"],
) -> Float[Array, "faces 3 sides"]:
    return jnp.where(where[:, None], this, that)
