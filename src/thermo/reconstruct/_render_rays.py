"""What a ray sees of a learned surface."""

from __future__ import annotations

from typing import NamedTuple, final

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._distance_network import with_gradient
from ._neural_surface import NeuralSurface
from ._opacity import section_opacity, weights
from ._sampling import drawn_by_weight, stratified, within_cube

_SPREAD = 0.2
"""Share of the places of a ray that are spread over all of it, whatever has been found [1]."""


@final
class Sampling(eqx.Module):
    """How many places a ray is looked at [1].

    - `search`: for the distance alone, to find where the surface is.
    - `rounds`: how often that is repeated with the places that the round before tells; with none
      the places of the search are the sections' ends.
    - `sections`: for distance, gradient and colour.
    """

    search: int = eqx.field(static=True, default=32)
    rounds: int = eqx.field(static=True, default=1)
    sections: int = eqx.field(static=True, default=32)


class Seen(NamedTuple):
    """What rays saw.

    - `colour`: accumulated, between 0 and 1, (rays, 3) [1].
    - `covered`: sum of the weights, (rays,) [1].
    - `depth`: where the weights are on average, (rays,) [half an edge].
    - `normal`: accumulated gradient of the distance, (rays, 3) [1].
    - `steepness`: |grad f| at every end, (rays, ends) [1].
    """

    colour: Float[Array, "rays 3"]
    covered: Float[Array, " rays"]
    depth: Float[Array, " rays"]
    normal: Float[Array, "rays 3"]
    steepness: Float[Array, "rays ends"]


def see(
    surface: NeuralSurface,
    origins: Float[Array, "rays 3"],
    directions: Float[Array, "rays 3"],
    sampling: Sampling,
    open_levels: Float[Array, ""],
    *,
    key: PRNGKeyArray,
) -> Seen:
    """Render rays: C = sum_i w_i c_i, with w of the opacity of sections (`section_opacity`).

    Distance, gradient and colour are asked for at the ends of sections, and a section has the mean
    of both its ends. Opacities of distances at shared ends telescope: up to the nearest approach
    what a ray has met is 1 - Phi(s f) / Phi(s f_0) however it is cut. NeuS extrapolates from the
    middle of each section instead, which covers the rim of a ball by four per cent too little.

    Arguments: `origins` [half an edge], `directions` of length one [1], `open_levels` of the
    encoding [1].

    Source: paper, appendix B.1 (checklist A2 to A4); Wang et al., NeurIPS 2021 (NeuS), section 3.1.
    """
    ends = _ends(surface, origins, directions, sampling, open_levels, key=key)
    rays, count = ends.shape
    places = _along(origins, directions, ends).reshape(-1, 3)
    distance, told, gradient = with_gradient(surface.distance, places, open_levels)
    steepness = jnp.sqrt(jnp.sum(gradient**2, axis=1) + 1e-12)
    sight = jnp.repeat(directions, count, axis=0)
    colour = surface.colour(places, sight, gradient / steepness[:, None], told)
    f = distance.reshape(rays, count)
    weight = weights(section_opacity(f[:, :-1], f[:, 1:], surface.sharpness()))
    covered = jnp.sum(weight, axis=1)
    # Half of a section's weight goes to either end.
    shared = 0.5 * (jnp.pad(weight, ((0, 0), (0, 1))) + jnp.pad(weight, ((0, 0), (1, 0))))

    def total(values: Float[Array, "places 3"]) -> Float[Array, "rays 3"]:
        return jnp.sum(shared[:, :, None] * values.reshape(rays, count, 3), axis=1)

    return Seen(
        total(colour),
        covered,
        jnp.sum(shared * ends, axis=1) / jnp.maximum(covered, 1e-6),
        total(gradient),
        steepness.reshape(rays, count),
    )


def _ends(
    surface: NeuralSurface,
    origins: Float[Array, "rays 3"],
    directions: Float[Array, "rays 3"],
    sampling: Sampling,
    open_levels: Float[Array, ""],
    *,
    key: PRNGKeyArray,
) -> Float[Array, "rays ends"]:
    """Ends of sections along rays [half an edge], close together where the surface is."""
    keys = jax.random.split(key, sampling.rounds + 1)
    near, far = within_cube(origins, directions)
    ends = stratified(near, far, sampling.search, keys[0])
    frozen = jax.lax.stop_gradient(surface)
    for number, one in enumerate(keys[1:]):
        places = _along(origins, directions, ends).reshape(-1, 3)
        distance = frozen.distance(places, open_levels)[0].reshape(ends.shape)
        length = jnp.diff(ends, axis=1)
        # As blunt as the spacing allows to be seen.
        sharp = jnp.asarray(32.0 * 4.0**number, ends.dtype)
        weight = _promise(distance[:, :-1], distance[:, 1:], length, sharp)
        even = length / jnp.maximum(jnp.sum(length, axis=1, keepdims=True), 1e-9)
        total = jnp.sum(weight, axis=1, keepdims=True)
        share = (1.0 - _SPREAD) * weight / jnp.maximum(total, 1e-6) + _SPREAD * even
        last = number + 1 == sampling.rounds
        count = sampling.sections + 1 if last else sampling.search
        ends = jax.lax.stop_gradient(drawn_by_weight(ends, share, count, one))
    return ends


def _promise(
    before: Float[Array, "rays sections"],
    after: Float[Array, "rays sections"],
    length: Float[Array, "rays sections"],
    sharpness: Float[Array, ""],
) -> Float[Array, "rays sections"]:
    """What sections could stop at the most of what comes to them [1].

    A distance changes by no more than the way: between its ends, where it may be alike, a section
    can come as near as (f_0 + f_1 - length) / 2, and a ray's nearest approach lies in such a one.
    """
    lowest = jnp.minimum(0.5 * (before + after - length), after)
    through = jnp.cumprod(1.0 - section_opacity(before, after, sharpness), axis=1)
    through = jnp.pad(through, ((0, 0), (1, 0)), constant_values=1.0)[:, :-1]
    return through * section_opacity(before, lowest, sharpness)


def _along(
    origins: Float[Array, "rays 3"],
    directions: Float[Array, "rays 3"],
    depths: Float[Array, "rays samples"],
) -> Float[Array, "rays samples 3"]:
    return origins[:, None, :] + depths[:, :, None] * directions[:, None, :]
