"""The colour of a place as seen from a side, learned."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._dense import Dense


@final
class ColourNetwork(eqx.Module):
    """c(x, v, n, z): red, green and blue from place, line of sight, normal and a feature z.

    Source: paper, section 4.1 (checklist A1); Yariv et al., NeurIPS 2020, section 3.2.
    """

    layers: Dense

    def __init__(self, told: int, width: int, *, key: PRNGKeyArray) -> None:
        """Grey everywhere. Arguments: `told` numbers a feature has [1], `width` of layers [1]."""
        self.layers = Dense((9 + told, width, width, 3), silent=True, key=key)

    def __call__(
        self,
        places: Float[Array, "points 3"],
        sight: Float[Array, "points 3"],
        normals: Float[Array, "points 3"],
        told: Float[Array, "points told"],
    ) -> Float[Array, "points 3"]:
        """Colours between 0 and 1 [1]; places in half an edge of the region, the rest [1]."""
        return jax.nn.sigmoid(self.layers(jnp.concatenate([places, sight, normals, told], axis=1)))
