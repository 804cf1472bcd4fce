"""All that is learned of an object: its distance, its colour, and how sharp its surface is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._backdrop import Backdrop
from ._colour_network import ColourNetwork
from ._distance_network import DistanceNetwork

_GAIN: Final = 10.0
"""What the logarithm of the sharpness is learned faster by than a weight [1]."""
_BLUNT: Final = 0.3
"""A sharpness of exp(3): the surface is as wide as a tenth of half an edge at first [1]."""


@final
class NeuralSurface(eqx.Module):
    """Distance f, colour c and sharpness s of the logistic function that turns f into opacity.

    Everything is in single precision, which training needs no more than.

    - `backdrop`: what stands behind, None where masks say what the object covers.
    - `log_sharpness`: log(s) over ten [1], s in one over half an edge of the region.

    Source: paper, section 4.1 and appendix B.1; Wang et al., NeurIPS 2021 (NeuS), section 3.1.
    """

    distance: DistanceNetwork
    colour: ColourNetwork
    backdrop: Backdrop | None
    log_sharpness: Float[Array, ""]

    def __init__(
        self,
        cells: Sequence[int],
        features: int = 2,
        width: int = 64,
        told: int = 15,
        *,
        masked: bool = True,
        key: PRNGKeyArray,
    ) -> None:
        """A grey, blunt ball.

        Arguments: `cells` an edge of each grid of the distance [1], coarse to fine, `features` of
        each corner, `width` of hidden layers, `told` numbers that the colour is told of a place;
        `masked`: whether masks are known.
        """
        first, second, third = jax.random.split(key, 3)
        self.distance = DistanceNetwork(cells, features, width, told, key=first)
        self.colour = ColourNetwork(told, width, key=second)
        self.backdrop = None if masked else Backdrop(key=third)
        self.log_sharpness = jnp.asarray(_BLUNT, jnp.float32)

    def sharpness(self) -> Float[Array, ""]:
        """s [1 / half an edge of the region]."""
        return jnp.exp(_GAIN * self.log_sharpness)
