"""Places of a surface that cameras read, and which pixels read each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float, Int

from thermo.errors import InputError
from thermo.mesh import Surface

from ._camera import Camera, project
from ._pixel_map import PixelMap, look
from ._pose import TURN, Axes, camera_to_world
from ._usable import footprint, places_of, usable_pixels
from ._visibility import seen_exactly

_FAR: Final = 100.0
"""A camera further away, over the size of the object, is one whose unit is another [1]."""


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

    def finest(self) -> Float[np.ndarray, " samples"]:
        """The footprint of each sample in the camera that sees it best [m]; infinite where none."""
        return np.where(self.seen, self.footprint, np.inf).min(axis=0)


@final
class _Looks(eqx.Module):
    """What all cameras see, and which of it can be used."""

    maps: tuple[PixelMap, ...]
    usable: tuple[Bool[np.ndarray, "_ _"], ...]


def place_samples(
    surface: Surface,
    cameras: Sequence[Camera],
    *,
    count: int = 600,
    grazing: float | int = 70.0,
    margin: int = 2,
    where: str = "cameras",
) -> SurfaceSamples:
    """Places spread evenly over what cameras see of a surface, each at the centre of a pixel.

    Of the places that usable pixels see (`usable_pixels`), each next one is that farthest from all
    that were taken. They are read as `samples_at` says; one that no camera reads is left out.

    Arguments:

    - `surface`: checked, turned outward [m]. `cameras`: in its world.
    - `count`: how many samples [1], at most; fewer where fewer pixels see the surface.
    - `grazing` [deg], `margin` [px]: as for `usable_pixels`.
    - `where`: what messages call the cameras.

    Raises `InputError` where a camera sees nothing, and says whether the other convention of axes
    would bring the object into its view.

    Source: paper, appendix A.1 and B.6 (checklist D1, F7); Gonzalez, Theor. Comput. Sci. 38 (1985)
    293, for the choice of the farthest.
    """
    if isinstance(count, bool) or count < 1:
        raise InputError(
            "so many samples cannot be placed", where="samples", value=count, limit="1 or more",
            remedy="give some hundreds",
        )  # fmt: skip
    looks = _looks(surface, cameras, grazing, margin, where)
    pairs = zip(looks.maps, looks.usable, strict=True)
    candidates = np.concatenate([places_of(surface, one)[mask] for one, mask in pairs])
    if len(candidates) == 0:
        raise InputError(
            "no pixel of these cameras can be used", where=where,
            value=f"{sum(len(one.hit) for one in looks.maps)} pixels see the surface, all of them "
            "at grazing angles or at an edge",
            limit=f"pixels within {grazing:g} degrees of the normal, {margin} from an edge",
            remedy="bring cameras closer, or raise samples.grazing and lower samples.margin",
        )  # fmt: skip
    found = _read_at(surface, cameras, candidates[_spread(candidates, count)], looks)
    # A place at the rim of all that is usable may lack one of its four pixels everywhere.
    kept = found.seen.any(axis=0)
    return SurfaceSamples(
        found.points[kept], found.seen[:, kept], found.pixels[:, kept], found.weights[:, kept],
        found.footprint[:, kept], found.cosine[:, kept],
    )  # fmt: skip


def samples_at(
    surface: Surface,
    cameras: Sequence[Camera],
    points: Float[np.ndarray, "samples 3"],
    *,
    grazing: float | int = 70.0,
    margin: int = 2,
    where: str = "cameras",
) -> SurfaceSamples:
    """How cameras read given points on or close to a surface [m].

    A camera reads a point by linear interpolation between four pixels, all of them usable, and by
    an unhindered line of sight. Arguments and what it raises: as for `place_samples`, but that a
    point which no camera reads stays.
    """
    return _read_at(surface, cameras, points, _looks(surface, cameras, grazing, margin, where))


def _looks(
    surface: Surface, cameras: Sequence[Camera], grazing: float, margin: int, where: str
) -> _Looks:
    maps = tuple(look(camera, surface) for camera in cameras)
    for camera, pixel_map in zip(cameras, maps, strict=True):
        _require_in_view(camera, surface, pixel_map, where)
    usable = tuple(
        usable_pixels(camera, surface, pixel_map, grazing=grazing, margin=margin)
        for camera, pixel_map in zip(cameras, maps, strict=True)
    )
    return _Looks(maps, usable)


def _read_at(
    surface: Surface,
    cameras: Sequence[Camera],
    points: Float[np.ndarray, "samples 3"],
    looks: _Looks,
) -> SurfaceSamples:
    reads = [
        _reading(camera, surface, pixel_map, mask, points)
        for camera, pixel_map, mask in zip(cameras, looks.maps, looks.usable, strict=True)
    ]
    return SurfaceSamples(points, *(np.stack(part) for part in zip(*reads, strict=True)))


def _spread(places: Float[np.ndarray, "places 3"], count: int) -> Int[np.ndarray, " picked"]:
    """Numbers of places, each the farthest from those before it."""
    first = int(np.argmin(np.linalg.norm(places - places.mean(axis=0), axis=1)))
    picked, away = [first], np.linalg.norm(places - places[first], axis=1)
    while len(picked) < count:
        farthest = int(np.argmax(away))
        if away[farthest] == 0.0:
            break
        picked.append(farthest)
        away = np.minimum(away, np.linalg.norm(places - places[farthest], axis=1))
    return np.array(picked)


def _reading(
    camera: Camera,
    surface: Surface,
    pixel_map: PixelMap,
    usable: Bool[np.ndarray, "rows columns"],
    points: Float[np.ndarray, "samples 3"],
) -> tuple[np.ndarray, ...]:
    """Whether a camera sees each sample, its four pixels and their weights, footprint, cosine."""
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
    seen[tried] = seen_exactly(camera, surface, points[tried])
    sides, cosines = footprint(camera, pixel_map).ravel(), pixel_map.cosine.ravel()
    nearest = np.take_along_axis(pixels, weights.argmax(axis=1)[:, None], 1)[:, 0]
    return (
        seen, pixels, np.where(used, weights, 0.0), np.where(seen, sides[nearest], np.nan),
        np.where(seen, cosines[nearest], np.nan),
    )  # fmt: skip


def _require_in_view(camera: Camera, surface: Surface, pixel_map: PixelMap, where: str) -> None:
    if len(pixel_map.hit):
        return
    middle = 0.5 * (surface.vertices.min(axis=0) + surface.vertices.max(axis=0))
    pixels, depth = project(camera, middle[None])
    place = "behind it" if depth[0] <= 0 else f"at pixel {np.round(pixels[0]).tolist()}"
    away = float(np.linalg.norm(camera.place() - middle)) / surface.diagonal()
    raise InputError(
        "the object is out of this camera's view", where=f"{where}: {camera.name}",
        value=f"the object's middle is {place}, the camera {away:.3g} times the object's size away",
        limit=f"within {camera.width} x {camera.height} pixels, before the camera, and no smaller "
        "than a pixel",
        remedy=_way_out(camera, middle, away),
    )  # fmt: skip


def _way_out(camera: Camera, middle: Float[np.ndarray, "3"], away: float) -> str:
    """What a user can do, by what would bring the object into view."""
    if _in_view(camera, TURN @ camera.pose, middle):
        return (
            "with its y and z axes turned round it would be in view: the poses are of the other "
            "convention, give camera_axes (from Python read_cameras(axes=...))"
        )
    for axes in Axes:
        file = camera_to_world(camera.pose, axes)
        if any(_in_view(camera, turn @ file, middle) for turn in (np.eye(4), TURN)):
            return (
                "with its matrices inverted it would be in view: they bring the world to the "
                "camera, where the format wants the camera to the world"
            )
    if away > _FAR:
        return (
            "is the unit of the poses another than that of the surface? For millimetres give "
            "camera_scale=0.001 (from Python read_cameras(scale=...))"
        )
    return "check that poses and surface share one world and one unit (camera_scale)"


def _in_view(camera: Camera, pose: Float[np.ndarray, "4 4"], point: Float[np.ndarray, "3"]) -> bool:
    other = Camera(
        camera.width, camera.height, camera.focal, camera.centre, pose, camera.distortion
    )
    pixels, depth = project(other, point[None])
    size = [camera.width, camera.height]
    return bool(depth[0] > 0 and np.all((pixels[0] >= 0) & (pixels[0] < size)))
