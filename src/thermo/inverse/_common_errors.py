"""Errors that all readings of a frame have in common, or all of a run."""

from __future__ import annotations

from collections.abc import Callable
from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

_NOTHING = 1e-12
"""Square of a direction's size, over the largest, below which it is rounding [1]."""

Filter = Callable[[Float[Array, "frames samples"]], Float[Array, "frames samples"]]
"""Whitens differences [K] by all errors but the common ones; linear."""


@final
class CommonErrors(eqx.Module):
    """Errors B a beside others that are whitened by L^-1, D = L^-1 B, a of variance one each.

    The first a is what all readings share, the others what those of each frame do. D is never
    held, which has a row for each reading: D'D = V s^2 V' has one for each frame.

    - `lasting`, `frame`: their standard deviations [K].
    - `turn`: V, (ways, ways), and `size`: s, (ways,) [1]; zero where frames fill up.
    """

    lasting: Float[Array, "*runs"]
    frame: Float[Array, "*runs"]
    turn: Float[Array, "*runs ways ways"]
    size: Float[Array, "*runs ways"]

    def variance(self) -> Float[Array, "*runs"]:
        """Of each reading [K2]."""
        return self.lasting**2 + self.frame**2


def common_errors(
    lasting: Float[Array, ""],
    frame: Float[Array, ""],
    used: Float[Array, "frames samples"],
    alone: Filter,
) -> CommonErrors:
    """Of standard deviations [K], in readings that are `used` (1, else 0) [1]."""
    count = len(used) + 1
    plain = CommonErrors(lasting, frame, jnp.eye(count), jnp.zeros(count))
    columns = _columns(plain, used, alone)
    gram = jax.lax.map(lambda way: _across(columns, columns(way)), jnp.eye(count))
    square, turn = jnp.linalg.eigh((gram + gram.T) / 2)
    square = jnp.where(square > _NOTHING * square[-1], square, 0.0)
    return CommonErrors(plain.lasting, plain.frame, turn, jnp.sqrt(square))


def without_common_errors(
    common: CommonErrors,
    used: Float[Array, "frames samples"],
    alone: Filter,
    white: Float[Array, "frames samples"],
) -> Float[Array, "frames samples"]:
    """(I + D D')^-1/2 times differences [1] that are whitened but for the common errors.

    It is I + D V f V' D', with f = ((1 + s^2)^-1/2 - 1) / s^2.

    Source: the square root of the Woodbury formula.
    """
    return _scaled(common, used, alone, white, 1 / jnp.sqrt(1 + common.size**2))


def with_common_errors(
    common: CommonErrors,
    used: Float[Array, "frames samples"],
    alone: Filter,
    freed: Float[Array, "frames samples"],
) -> Float[Array, "frames samples"]:
    """(I + D D')^1/2 times values [1], the inverse of `without_common_errors`."""
    return _scaled(common, used, alone, freed, jnp.sqrt(1 + common.size**2))


def _scaled(
    common: CommonErrors,
    used: Float[Array, "frames samples"],
    alone: Filter,
    white: Float[Array, "frames samples"],
    factor: Float[Array, " ways"],
) -> Float[Array, "frames samples"]:
    columns, square = _columns(common, used, alone), common.size**2
    share = jnp.where(square > 0, (factor - 1) / jnp.where(square > 0, square, 1.0), 0.0)
    along = common.turn @ (share * (common.turn.T @ _across(columns, white)))
    return white + columns(along)


Columns = Callable[[Float[Array, " ways"]], Float[Array, "frames samples"]]


def _columns(common: CommonErrors, used: Float[Array, "frames samples"], alone: Filter) -> Columns:
    """D times amplitudes [1]."""

    def columns(amplitudes: Float[Array, " ways"]) -> Float[Array, "frames samples"]:
        each = common.lasting * amplitudes[0] + common.frame * amplitudes[1:]
        return alone(each[:, None] * used)

    return columns


def _across(columns: Columns, values: Float[Array, "frames samples"]) -> Float[Array, " ways"]:
    """D' times values [1]."""
    _, pull = jax.vjp(columns, jnp.zeros(len(values) + 1))
    (found,) = pull(values)
    return found
