"""A trained surface as a camera sees it."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.imaging import Camera, pixel_centres, rays

from ._neural_surface import NeuralSurface
from ._photograph import Photograph
from ._region import to_unit
from ._render_rays import Sampling, Seen, see
from ._train import Trained

_RAYS: Final = 4096
"""Rays that are rendered at a time [1]: one program serves pictures of every size."""
_FINE: Final = Sampling(search=64, rounds=2, sections=64)
"""More places a ray than training needs, since nothing has to be learned from them."""


class Picture(NamedTuple):
    """What a camera sees.

    - `colour`: on black ground, (rows, columns, 3), 0 to 1 [1].
    - `covered`: share of the pixel that the object covers, (rows, columns) [1].
    - `depth`: along the line of sight, (rows, columns) [m]; NaN where less than half is covered.
    - `normal`: outward, of length one where anything is covered, (rows, columns, 3) [1].
    """

    colour: Float[np.ndarray, "rows columns 3"]
    covered: Float[np.ndarray, "rows columns"]
    depth: Float[np.ndarray, "rows columns"]
    normal: Float[np.ndarray, "rows columns 3"]


def picture(trained: Trained, camera: Camera) -> Picture:
    """Render every pixel of a camera in its world's metres.

    Arguments: `camera`: one that the surface was trained on, or any other in the same world.

    Source: paper, appendix B.1 (checklist A4), with `see`.
    """
    directions = rays(camera, pixel_centres(camera))
    place = to_unit(trained.region, camera.place()[None])
    origins = np.broadcast_to(place, directions.shape)
    # A lens may bring nothing to a pixel at the rim of the picture; it then shows nothing.
    blind = np.logical_not(np.isfinite(directions).all(axis=1))
    directions = np.where(blind[:, None], [0.0, 0.0, 1.0], directions)
    parts = []
    for start in range(0, len(directions), _RAYS):
        rows = np.minimum(np.arange(start, start + _RAYS), len(directions) - 1)
        pair = (jnp.asarray(part[rows], jnp.float32) for part in (origins, directions))
        parts.append(jax.tree.map(np.asarray, _seen(trained.surface, *pair)))
    joined = (np.concatenate(part)[: len(directions)] for part in zip(*parts, strict=True))
    seen: Any = Seen(*joined)  # pyright: ignore[reportArgumentType]
    covered = np.where(blind, 0.0, seen.covered)
    length = np.linalg.norm(seen.normal, axis=1, keepdims=True)
    depth = np.where(covered >= 0.5, seen.depth * trained.region.half, np.nan)
    shape = (camera.height, camera.width)
    return Picture(
        np.where(blind[:, None], 0.0, seen.colour).reshape(*shape, 3).astype(float),
        covered.reshape(shape).astype(float),
        depth.reshape(shape).astype(float),
        (seen.normal / np.maximum(length, 1e-6)).reshape(*shape, 3).astype(float),
    )


def psnr(seen: Picture, photograph: Photograph) -> float:
    """How alike what was rendered and what was photographed are over the object [dB].

    10 log10(1 / mean square of what differs), of colours from 0 to 1 [1] on black ground. Pixels
    weigh as much as the object covers of them: as the mask says, or the picture where there is
    none. NaN where the object is not seen.
    """
    weight = seen.covered if photograph.mask is None else photograph.mask
    square = ((seen.colour - weight[..., None] * photograph.colour) ** 2).mean(axis=2)
    total = float(weight.sum())
    if total == 0.0:
        return float("nan")
    return float(-10.0 * np.log10(max(float((weight * square).sum()) / total, 1e-12)))


@eqx.filter_jit
def _seen(
    surface: NeuralSurface, origins: Float[Array, "rays 3"], directions: Float[Array, "rays 3"]
) -> Seen:
    levels = jnp.asarray(len(surface.distance.encoding.cells), jnp.float32)
    return see(surface, origins, directions, _FINE, levels, key=jax.random.key(0))
