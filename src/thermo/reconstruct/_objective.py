"""What training makes small: wrong colours, distances that are none, wrong silhouettes."""

from __future__ import annotations

from typing import NamedTuple, final

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._distance_network import with_gradient
from ._neural_surface import NeuralSurface
from ._render_rays import Sampling, see


@final
class Balance(eqx.Module):
    """Weights of the parts of the objective beside the colours' one [1].

    - `eikonal`: of |grad f| = 1. `mask`: of the silhouettes.
    - `anywhere`: places a ray, drawn from the whole region, that |grad f| = 1 is asked of as well.

    Source: Wang et al., NeurIPS 2021 (NeuS), section 3.3.
    """

    eikonal: float = eqx.field(static=True, default=0.1)
    mask: float = eqx.field(static=True, default=0.1)
    anywhere: int = eqx.field(static=True, default=4)


class Rays(NamedTuple):
    """Rays and what their pixels show.

    - `origins`: (rays, 3) [half an edge]. `directions`: of length one, (rays, 3) [1].
    - `colour`: (rays, 3), 0 to 1 [1]. `mask`: share that the object covers, (rays,) [1].
    """

    origins: Float[Array, "rays 3"]
    directions: Float[Array, "rays 3"]
    colour: Float[Array, "rays 3"]
    mask: Float[Array, " rays"]


class Parts(NamedTuple):
    """The parts of the objective, each before its weight [1]."""

    colour: Float[Array, ""]
    eikonal: Float[Array, ""]
    mask: Float[Array, ""]
    square: Float[Array, ""]


def objective(
    surface: NeuralSurface,
    rays: Rays,
    sampling: Sampling,
    balance: Balance,
    open_levels: Float[Array, ""],
    *,
    key: PRNGKeyArray,
) -> tuple[Float[Array, ""], Parts]:
    """L1 of colour + eikonal part + cross-entropy of coverage and mask [1].

    Without masks the colours are those of the object before the backdrop, C + (1 - sum w) b, and
    there is no third part.

    Source: paper, appendix B.1 (checklist A5); Wang et al., NeurIPS 2021 (NeuS), section 3.3.
    """
    first, second = jax.random.split(key)
    seen = see(surface, rays.origins, rays.directions, sampling, open_levels, key=first)
    pixels = jnp.maximum(jnp.sum(rays.mask), 1.0)
    if surface.backdrop is None:
        # A pixel at the rim shows the object in part: on black ground, both sides miss the same
        # part. Compared with the object's own colour it would pull the surface outwards.
        apart = seen.colour - rays.mask[:, None] * rays.colour
        covered = jnp.clip(seen.covered, 1e-3, 1.0 - 1e-3)
        entropy = rays.mask * jnp.log(covered) + (1.0 - rays.mask) * jnp.log1p(-covered)
    else:
        behind = surface.backdrop(rays.directions)
        apart = seen.colour + (1.0 - seen.covered)[:, None] * behind - rays.colour
        entropy = jnp.zeros_like(rays.mask)
    colour = jnp.sum(jnp.abs(apart)) / pixels
    square = jnp.sum(apart**2 * rays.mask[:, None]) / (3.0 * pixels)
    spread = jax.random.uniform(
        second, (balance.anywhere * rays.mask.shape[0], 3), jnp.float32, minval=-1.0, maxval=1.0
    )
    _, _, gradient = with_gradient(surface.distance, spread, open_levels)
    steepness = jnp.sqrt(jnp.sum(gradient**2, axis=1) + 1e-12)
    eikonal = jnp.mean((seen.steepness - 1.0) ** 2) + jnp.mean((steepness - 1.0) ** 2)
    parts = Parts(colour, eikonal, -jnp.mean(entropy), square)
    return parts.colour + balance.eikonal * parts.eikonal + balance.mask * parts.mask, parts
