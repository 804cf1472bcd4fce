"""The pixels that training draws from, as rays of the region."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int, PRNGKeyArray
from scipy import ndimage

from thermo.errors import InputError
from thermo.imaging import pixel_centres, rays

from ._objective import Rays
from ._photograph import Photograph
from ._region import Region, to_unit

_NEAR: Final = 0.06
"""What counts as near the object, over the mean edge of the picture [1]."""
_FAR_SHARE: Final = 0.1
"""Share of the rays of a step that are drawn away from the object [1]."""


@final
class Pixels(eqx.Module):
    """All pixels of all photographs whose rays meet the region.

    - `rays`: of every such pixel, and what it shows.
    - `near`: numbers of those on the object or close to it. `far`: of the others.
    - `masked`: whether masks are known; without, every pixel counts as near.
    """

    rays: Rays
    near: Int[Array, " near"]
    far: Int[Array, " far"]
    masked: bool = eqx.field(static=True)

    def drawn(self, count: int, key: PRNGKeyArray) -> Rays:
        """`count` rays [1], most of them near the object: far ones are soon known to be empty."""
        first, second = jax.random.split(key)
        away = min(int(_FAR_SHARE * count), count) if self.far.size else 0
        rows = self.near[jax.random.randint(first, (count - away,), 0, self.near.size)]
        if away:
            others = self.far[jax.random.randint(second, (away,), 0, self.far.size)]
            rows = jnp.concatenate([rows, others])
        return Rays(*(part[rows] for part in self.rays))


def pixels_of(photographs: Sequence[Photograph], region: Region) -> Pixels:
    """Rays in the region's own unit, half its edge, in single precision.

    Raises `InputError` where masks are known of some photographs and not of others, and where no
    ray meets the region.
    """
    known = [one.mask is not None for one in photographs]
    if any(known) and not all(known):
        raise InputError(
            "some photographs have a mask and others none",
            where=photographs[known.index(False)].file, value=f"{sum(known)} of {len(known)}",
            limit="a mask for every photograph, or for none",
            remedy="add the masks that are missing, or leave these photographs out",
        )  # fmt: skip
    parts = [_of_one(one, region) for one in photographs]
    columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
    near = columns.pop().astype(bool)
    if not near.any():
        raise InputError(
            "no pixel on the object looks into the region", where="photographs",
            value=f"{len(near)} rays meet the region",
            limit="cameras that see the object inside the region",
            remedy="check poses, their axes and scale, and the box that was given",
        )  # fmt: skip
    drawn = Rays(*(jnp.asarray(column, dtype=jnp.float32) for column in columns))
    numbers = [jnp.asarray(np.flatnonzero(one)) for one in (near, ~near)]
    return Pixels(drawn, numbers[0], numbers[1], all(known))


def _of_one(photograph: Photograph, region: Region) -> tuple[np.ndarray, ...]:
    camera = photograph.camera
    direction = rays(camera, pixel_centres(camera))
    place = to_unit(region, camera.place()[None])
    mask = photograph.mask
    shown = np.ones((camera.height, camera.width)) if mask is None else mask
    reach = max(1, round(_NEAR * (camera.height + camera.width) / 2))
    near = ndimage.maximum_filter(shown, size=2 * reach + 1).ravel() > 0
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (-1.0 - place) / direction, (1.0 - place) / direction
        enters = np.minimum(first, second).max(axis=1)
        leaves = np.maximum(first, second).min(axis=1)
    meets = np.isfinite(direction).all(axis=1) & (leaves > np.maximum(enters, 0.0))
    origin = np.broadcast_to(place, direction.shape)
    parts = (origin, direction, photograph.colour.reshape(-1, 3), shown.ravel(), near)
    return tuple(part[meets] for part in parts)
