"""Places of a surface that cameras read, and which pixels read each."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial import KDTree

from thermo.errors import InputError

from ._camera import project
from ._looks import Looks
from ._usable import footprint, places_of
from ._visibility import in_sight, on_surface


@final
class SurfaceSamples(eqx.Module):
    """Samples of a surface, and how each camera reads them; all leaves are NumPy arrays.

    - `points`: (samples, 3) [m].
    - `seen`: whether a camera reads a sample, (cameras, samples).
    - `pixels`: the four pixels that it is read from, numbered row after row, (cameras, samples, 4);
      `weights`: theirs, of sum 1 [1].
    - `footprint`: side of the square as large as what one pixel sees there, (cameras, samples) [m];
      NaN where the camera does not see it.
    - `cosine`: between normal and line of sight, (cameras, samples) [1]; NaN likewise.
    """

    points: Float[np.ndarray, "samples 3"]
    seen: Bool[np.ndarray, "cameras samples"]
    pixels: Int[np.ndarray, "cameras samples 4"]
    weights: Float[np.ndarray, "cameras samples 4"]
    footprint: Float[np.ndarray, "cameras samples"]
    cosine: Float[np.ndarray, "cameras samples"]


def place_samples(looks: Looks, *, count: int = 600) -> SurfaceSamples:
    """Places spread evenly over what cameras see of a surface, each at the centre of a pixel.

    Of the places that usable pixels see (`usable_pixels`), each next one is that farthest from all
    that were taken. They are read as `samples_at` says; one that no camera reads is left out.

    Arguments: `looks`, made by `looks_of`; `count`, how many samples [1], at most; fewer where
    fewer pixels see the surface.

    Raises `InputError` for a count below 1.

    Source: paper, appendix A.1 and B.6 (checklist D1, F7); Gonzalez, Theor. Comput. Sci. 38 (1985)
    293, for the choice of the farthest.
    """
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 1:
        raise InputError(
            "so many samples cannot be placed", where="samples", value=count,
            limit="a whole number, 1 or more",
            remedy="give some hundreds",
        )  # fmt: skip
    pairs = zip(looks.maps, looks.usable, strict=True)
    candidates = np.concatenate([places_of(looks.surface, one)[mask] for one, mask in pairs])
    found = samples_at(looks, candidates[_spread(candidates, count)])
    # A place at the rim of all that is usable may lack one of its four pixels everywhere.
    kept = found.seen.any(axis=0)
    return SurfaceSamples(
        found.points[kept], found.seen[:, kept], found.pixels[:, kept], found.weights[:, kept],
        found.footprint[:, kept], found.cosine[:, kept],
    )  # fmt: skip


def samples_at(looks: Looks, points: Float[np.ndarray, "samples 3"]) -> SurfaceSamples:
    """How cameras read given points on or close to a surface [m].

    A camera reads a point by linear interpolation between four pixels, all of them usable, and by
    an unhindered line of sight. A point that no camera reads stays.

    Arguments: `looks`, made by `looks_of`; `points` (samples, 3).

    Raises `InputError` for points that are not finite.

    Source: paper, appendix B.6 (checklist D1, D3).
    """
    return read_at(looks, points, *on_surface(looks.surface, points))


def read_at(
    looks: Looks,
    points: Float[np.ndarray, "samples 3"],
    places: Float[np.ndarray, "samples 3"],
    normals: Float[np.ndarray, "samples 3"],
) -> SurfaceSamples:
    """`samples_at` for points [m] whose `places` on the surface and `normals` are known."""
    reads = [
        _reading(looks, number, points, places, normals) for number in range(len(looks.cameras))
    ]
    return SurfaceSamples(points, *(np.stack(part) for part in zip(*reads, strict=True)))


def _spread(places: Float[np.ndarray, "places 3"], count: int) -> Int[np.ndarray, " picked"]:
    """Numbers of places, each the farthest from those before it."""
    first = int(np.argmin(np.linalg.norm(places - places.mean(axis=0), axis=1)))
    picked, away = [first], np.linalg.norm(places - places[first], axis=1)
    tree = KDTree(places, balanced_tree=False, compact_nodes=False)
    while len(picked) < count:
        farthest = int(np.argmax(away))
        if away[farthest] == 0.0:
            break
        picked.append(farthest)
        # No place is farther from those before than this one, so that none farther from it changes.
        reach = away[farthest] * (1 + 1e-9)
        near = np.asarray(tree.query_ball_point(places[farthest], reach, return_sorted=False))
        there = np.linalg.norm(places[near] - places[farthest], axis=1)
        away[near] = np.minimum(away[near], there)
    return np.array(picked)


def _reading(
    looks: Looks,
    number: int,
    points: Float[np.ndarray, "samples 3"],
    places: Float[np.ndarray, "samples 3"],
    normals: Float[np.ndarray, "samples 3"],
) -> tuple[np.ndarray, ...]:
    """Whether a camera sees each sample, its four pixels and their weights, footprint, cosine."""
    camera, pixel_map, usable = looks.cameras[number], looks.maps[number], looks.usable[number]
    rows, columns = usable.shape
    place, _ = project(camera, points)
    with np.errstate(invalid="ignore"):
        inside = np.all((place >= 0) & (place <= [columns - 1, rows - 1]), axis=1)
    place = np.where(inside[:, None], place, 0.0)
    # A frame may be one pixel wide: its neighbour is then itself, with no weight.
    low = np.minimum(np.floor(place), np.maximum([columns - 2, rows - 2], 0)).astype(int)
    high = np.minimum(low + 1, [columns - 1, rows - 1])
    share = np.clip(place - low, 0.0, 1.0)
    column, row = (np.stack([low[:, k], high[:, k]], 1) for k in (0, 1))
    across, down = (np.stack([1 - share[:, k], share[:, k]], 1) for k in (0, 1))
    pixels = (row[:, :, None] * columns + column[:, None, :]).reshape(-1, 4)
    weights = (down[:, :, None] * across[:, None, :]).reshape(-1, 4)
    used = weights > 1e-9
    tried = np.flatnonzero(inside & np.all(usable.ravel()[pixels] | ~used, axis=1))
    seen = np.zeros(len(points), bool)
    seen[tried] = in_sight(camera, looks.caster, places[tried], normals[tried])
    sides, cosines = footprint(camera, pixel_map).ravel(), pixel_map.cosine.ravel()
    nearest = np.take_along_axis(pixels, weights.argmax(axis=1)[:, None], 1)[:, 0]
    return (
        seen, pixels, np.where(used, weights, 0.0), np.where(seen, sides[nearest], np.nan),
        np.where(seen, cosines[nearest], np.nan),
    )  # fmt: skip
