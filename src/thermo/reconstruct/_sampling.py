"""Where along its ray a pixel is looked at: everywhere first, then where the surface is."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray


def within_cube(
    origins: Float[Array, "rays 3"], directions: Float[Array, "rays 3"]
) -> tuple[Float[Array, " rays"], Float[Array, " rays"]]:
    """Where rays enter and leave [-1, 1]^3 [half an edge]; both alike where they miss it.

    Arguments: `origins` [half an edge], `directions` of length one [1].
    """
    safe = jnp.where(jnp.abs(directions) < 1e-9, 1e-9, directions)
    first, second = (-1.0 - origins) / safe, (1.0 - origins) / safe
    near = jnp.maximum(jnp.minimum(first, second).max(axis=1), 0.0)
    far = jnp.maximum(first, second).min(axis=1)
    return near, jnp.maximum(far, near)


def stratified(
    near: Float[Array, " rays"], far: Float[Array, " rays"], count: int, key: PRNGKeyArray
) -> Float[Array, "rays samples"]:
    """One place in each of `count` [1] equal parts of each ray [half an edge], drawn at random."""
    share = jax.random.uniform(key, (near.shape[0], count), near.dtype)
    share = (jnp.arange(count, dtype=near.dtype) + share) / count
    return near[:, None] + (far - near)[:, None] * share


def drawn_by_weight(
    ends: Float[Array, "rays ends"],
    weight: Float[Array, "rays sections"],
    count: int,
    key: PRNGKeyArray,
) -> Float[Array, "rays samples"]:
    """`count` [1] places a ray [half an edge], stratified by the weight [1] of its sections.

    The inverse of the cumulative weight at one random share in each of `count` equal parts; within
    a section the weight is spread evenly.

    Source: Mildenhall et al., ECCV 2020, section 5.2.
    """
    total = jnp.cumsum(weight + 1e-5, axis=1)
    total = jnp.concatenate([jnp.zeros_like(total[:, :1]), total], axis=1)
    total = total / total[:, -1:]
    share = jax.random.uniform(key, (ends.shape[0], count), ends.dtype)
    share = (jnp.arange(count, dtype=ends.dtype) + share) / count
    # A share lies past as many ends as it is above: rays have few sections, and counting them
    # keeps all rays in step where a search would not.
    at = jnp.sum(share[:, :, None] >= total[:, None, 1:-1], axis=2)
    low, high = (jnp.take_along_axis(total, at + step, axis=1) for step in (0, 1))
    start, end = (jnp.take_along_axis(ends, at + step, axis=1) for step in (0, 1))
    return start + (end - start) * (share - low) / jnp.maximum(high - low, 1e-9)
