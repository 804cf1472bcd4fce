"""What cameras see of a surface, looked at once for all that is asked of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from jaxtyping import Bool, Float

from thermo.errors import InputError
from thermo.mesh import Caster, Surface, caster_of

from ._camera import Camera, project
from ._pixel_map import PixelMap, look_by
from ._pose import TURN, Axes, camera_to_world
from ._usable import usable_pixels


@final
@dataclass(frozen=True)
class Looks:
    """What cameras see of a surface, and which of it can be used. Make one with `looks_of`.

    Arguments:

    - `surface`: what is looked at [m]; `caster`: the same, for rays.
    - `cameras`: in the surface's world; all below is in their order.
    - `maps`: what the pixels see. `usable`: which of them tell one place's temperature,
      (rows, columns) each.
    """

    surface: Surface
    caster: Caster
    cameras: tuple[Camera, ...]
    maps: tuple[PixelMap, ...]
    usable: tuple[Bool[np.ndarray, "_ _"], ...]


def looks_of(
    surface: Surface,
    cameras: Sequence[Camera],
    *,
    grazing: float | int = 70.0,
    margin: int = 2,
    where: str = "cameras",
) -> Looks:
    """Look at a surface by all cameras, and pick the pixels that can be used.

    Arguments:

    - `surface`: checked, turned outward [m]. `cameras`: in its world.
    - `grazing` [deg], `margin` [px]: as for `usable_pixels`.
    - `where`: what messages call the cameras.

    Raises `InputError` as `look_all` and `usable_pixels` do, and where no pixel can be used.
    """
    caster = caster_of(surface)
    maps = _in_view(caster, surface, cameras, where)
    usable = tuple(
        usable_pixels(camera, surface, pixel_map, grazing=grazing, margin=margin)
        for camera, pixel_map in zip(cameras, maps, strict=True)
    )
    if not any(one.any() for one in usable):
        raise InputError(
            "no pixel of these cameras can be used", where=where,
            value=f"{sum(len(one.hit) for one in maps)} pixels see the surface, all of them "
            "at grazing angles or at an edge",
            limit=f"pixels within {grazing:g} degrees of the normal, {margin} from an edge",
            remedy="bring cameras closer, or raise samples.grazing and lower samples.margin",
        )  # fmt: skip
    return Looks(surface, caster, tuple(cameras), maps, usable)


def look_all(
    surface: Surface, cameras: Sequence[Camera], *, where: str = "cameras"
) -> tuple[PixelMap, ...]:
    """What the pixels of each camera see of a surface [m], none of which may see nothing.

    Raises `InputError`, `where` naming the cameras, for one that sees nothing, and says whether the
    other convention of axes or another unit would bring the object into its view; and as `look`
    does.
    """
    return _in_view(caster_of(surface), surface, cameras, where)


def _in_view(
    caster: Caster, surface: Surface, cameras: Sequence[Camera], where: str
) -> tuple[PixelMap, ...]:
    maps = tuple(look_by(caster, camera, surface) for camera in cameras)
    for camera, pixel_map in zip(cameras, maps, strict=True):
        if len(pixel_map.hit) == 0:
            raise _out_of_view(camera, surface, where)
    return maps


def _out_of_view(camera: Camera, surface: Surface, where: str) -> InputError:
    middle = 0.5 * (surface.vertices.min(axis=0) + surface.vertices.max(axis=0))
    pixels, depth = project(camera, middle[None])
    place = "behind it" if depth[0] <= 0 else f"at pixel {np.round(pixels[0]).tolist()}"
    away = float(np.linalg.norm(camera.place() - middle)) / surface.diagonal()
    return InputError(
        "the object is out of this camera's view", where=f"{where}: {camera.name}",
        value=f"the object's middle is {place}, the camera {away:.3g} times the object's size away",
        limit=f"within {camera.width} x {camera.height} pixels, before the camera, and no smaller "
        "than a pixel",
        remedy=_way_out(camera, middle, away),
    )  # fmt: skip


def _way_out(camera: Camera, middle: Float[np.ndarray, "3"], away: float) -> str:
    """What a user can do, by what would bring the object into view."""
    if _shows(camera, TURN @ camera.pose, middle):
        return (
            "with its y and z axes turned round it would be in view: the poses are of the other "
            "convention, give camera_axes (from Python read_cameras(axes=...))"
        )
    for axes in Axes:
        file = camera_to_world(camera.pose, axes)
        if any(_shows(camera, turn @ file, middle) for turn in (np.eye(4), TURN)):
            return (
                "with its matrices inverted it would be in view: they bring the world to the "
                "camera, where the format wants the camera to the world"
            )
    # So far away the whole object is smaller than a pixel.
    if away > camera.focal.max():
        return (
            "is the unit of the poses another than that of the surface? For millimetres give "
            "camera_scale=0.001 (from Python read_cameras(scale=...))"
        )
    return "check that poses and surface share one world and one unit (camera_scale)"


def _shows(camera: Camera, pose: Float[np.ndarray, "4 4"], point: Float[np.ndarray, "3"]) -> bool:
    other = Camera(
        camera.width, camera.height, camera.focal, camera.centre, pose, camera.distortion
    )
    pixels, depth = project(other, point[None])
    size = [camera.width, camera.height]
    return bool(depth[0] > 0 and np.all((pixels[0] >= 0) & (pixels[0] < size)))
