"""What stands behind the object, where no masks say which pixels show it."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._dense import Dense
from ._grid_encoding import GridEncoding

_CELLS = (8, 32)


@final
class Backdrop(eqx.Module):
    """b(v): the colour of all that is far away, by the line of sight alone.

    What stands near the object, such as a table, looks another way from each camera; masks or a
    box that leaves it out are then needed.
    """

    encoding: GridEncoding
    layers: Dense

    def __init__(self, *, key: PRNGKeyArray) -> None:
        """Grey all around."""
        first, second = jax.random.split(key)
        self.encoding = GridEncoding(_CELLS, 2, key=first)
        self.layers = Dense((3 + 2 * len(_CELLS), 32, 3), silent=True, key=second)

    def __call__(self, sight: Float[Array, "rays 3"]) -> Float[Array, "rays 3"]:
        """Colours between 0 and 1 [1] along lines of sight of length one [1]."""
        levels = jnp.asarray(float(len(_CELLS)), sight.dtype)
        encoded = self.encoding(sight, levels)
        return jax.nn.sigmoid(self.layers(jnp.concatenate([sight, encoded], axis=1)))
