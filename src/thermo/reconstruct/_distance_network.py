"""The signed distance from the surface, learned."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._dense import Dense
from ._grid_encoding import GridEncoding

FIRST_RADIUS: Final = 0.5
"""Radius of the ball that every surface begins as, over half the region's edge [1]."""


@final
class DistanceNetwork(eqx.Module):
    """f(x) = |x| - r + m(x, g(x)), negative inside, and a feature of the place for its colour.

    g is a grid encoding and m a small network that is silent at first, so that training begins at a
    ball of radius r whose f is an exact distance.

    Source: paper, section 4.1 (checklist A1); Atzmon and Lipman, CVPR 2020 (a ball to begin with).
    """

    encoding: GridEncoding
    layers: Dense

    def __init__(
        self,
        cells: Sequence[int],
        features: int,
        width: int,
        told: int,
        *,
        key: PRNGKeyArray,
    ) -> None:
        """A ball.

        Arguments: `cells` an edge of each grid [1], `features` of each corner [1], `width` of the
        hidden layer [1], `told` numbers that the colour is told of a place [1].
        """
        grids, rest = jax.random.split(key)
        self.encoding = GridEncoding(cells, features, key=grids)
        inputs = 3 + features * len(self.encoding.cells)
        self.layers = Dense((inputs, width, 1 + told), silent=True, key=rest)

    def __call__(
        self, places: Float[Array, "points 3"], open_levels: Float[Array, ""]
    ) -> tuple[Float[Array, " points"], Float[Array, "points told"]]:
        """Distance [half an edge] and feature [1] at places [half an edge] of [-1, 1]^3."""
        encoded = self.encoding(places, open_levels)
        answer = self.layers(jnp.concatenate([places, encoded], axis=1))
        # The root is smooth at the middle as well.
        radius = jnp.sqrt(jnp.sum(places**2, axis=1) + 1e-6)
        return radius - FIRST_RADIUS + answer[:, 0], answer[:, 1:]


def with_gradient(
    network: DistanceNetwork, places: Float[Array, "points 3"], open_levels: Float[Array, ""]
) -> tuple[Float[Array, " points"], Float[Array, "points told"], Float[Array, "points 3"]]:
    """Distance [half an edge], feature [1] and grad f [1] at places [half an edge]."""

    def distance(where: Float[Array, "points 3"]) -> tuple[Array, Array]:
        return network(where, open_levels)

    # f of a place depends on that place alone: one product gives the gradients of all.
    distances, pull, told = jax.vjp(distance, places, has_aux=True)
    (gradient,) = pull(jnp.ones_like(distances))
    return distances, told, gradient
