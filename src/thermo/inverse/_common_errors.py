"""Errors that all readings of a frame have in common, or all of a run."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

_NOTHING = 1e-12
"""Square of a direction's size, over the largest, below which it is rounding [1]."""


@final
class CommonErrors(eqx.Module):
    """Errors D a with independent a of variance one, beside others that are whitened: D is, too.

    - `ways`: orthonormal directions Q of D = Q s V', (frames, samples, ways) [1]; those that fill
      up are zero.
    - `size`: s, (ways,) [1]; `variance`: what they add to that of each reading [K2].
    """

    ways: Float[Array, "*runs frames samples ways"]
    size: Float[Array, "*runs ways"]
    variance: Float[Array, "*runs"]


def common_errors(columns: Float[Array, "ways frames samples"], variance: float) -> CommonErrors:
    """Errors whose whitened columns D [1] are given; `variance` as in `CommonErrors` [K2]."""
    square, turn = jnp.linalg.eigh(jnp.einsum("kts,lts->kl", columns, columns))
    square = jnp.where(square > _NOTHING * square[-1], square, 0.0)
    size = jnp.sqrt(square)
    scale = jnp.where(size > 0, 1 / jnp.where(size > 0, size, 1.0), 0.0)
    ways = jnp.einsum("kts,kl->tsl", columns, turn * scale)
    return CommonErrors(ways, size, jnp.asarray(variance, float))


def without_common_errors(
    common: CommonErrors, white: Float[Array, "frames samples"]
) -> Float[Array, "frames samples"]:
    """(I + D D')^-1/2 times differences [1] that are whitened but for the common errors.

    Source: the square root of the Woodbury formula.
    """
    return _scaled(common, white, 1 / jnp.sqrt(1 + common.size**2))


def with_common_errors(
    common: CommonErrors, freed: Float[Array, "frames samples"]
) -> Float[Array, "frames samples"]:
    """(I + D D')^1/2 times values [1], the inverse of `without_common_errors`."""
    return _scaled(common, freed, jnp.sqrt(1 + common.size**2))


def _scaled(
    common: CommonErrors, white: Float[Array, "frames samples"], factor: Float[Array, " ways"]
) -> Float[Array, "frames samples"]:
    along = jnp.einsum("tsl,ts->l", common.ways, white)
    return white + common.ways @ ((factor - 1) * along)
