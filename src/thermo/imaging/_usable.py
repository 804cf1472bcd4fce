"""Which pixels tell the temperature of one place of a surface."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

from thermo.errors import InputError
from thermo.mesh import Surface
from thermo.observe import check_number

from ._camera import Camera
from ._pixel_map import PixelMap

_JUMP: Final = 2.0
"""Neighbouring pixels see places further apart than this, over the distance that a face at the
grazing limit leaves them, only across an edge of the picture [1]."""


def footprint(camera: Camera, pixel_map: PixelMap) -> Float[np.ndarray, "rows columns"]:
    """Side of the square as large as what each pixel sees of the surface [m]; NaN where nothing is.

    sqrt(z^2 / (f_x f_y cos theta)), z the depth and theta the angle between normal and line of
    sight: the surface takes in as much solid angle as the pixel. The lens is left out.
    """
    cosine = np.maximum(np.abs(pixel_map.cosine), np.finfo(float).eps)
    return pixel_map.depth / np.sqrt(camera.focal[0] * camera.focal[1] * cosine)


def places_of(surface: Surface, pixel_map: PixelMap) -> Float[np.ndarray, "rows columns 3"]:
    """Where each pixel's line of sight meets the surface [m]; NaN where it does not."""
    places = np.full((pixel_map.triangle.size, 3), np.nan)
    places[pixel_map.hit] = np.einsum(
        "pk,pki->pi", pixel_map.weights, surface.vertices[pixel_map.corners]
    )
    return places.reshape(*pixel_map.triangle.shape, 3)


def usable_pixels(
    camera: Camera,
    surface: Surface,
    pixel_map: PixelMap,
    *,
    grazing: float | int = 70.0,
    margin: int = 2,
) -> Bool[np.ndarray, "rows columns"]:
    """Pixels that see the surface, not at grazing angles and not at an edge of the picture.

    Beyond 60 to 70 degrees the emissivity of most materials falls; pixels at a silhouette, or where
    one part of the object stands before another, mix two temperatures.

    Arguments:

    - `grazing`: the largest angle between normal and line of sight [deg].
    - `margin`: how many pixels next to an edge are left out [px].

    Raises `InputError` for limits that make no sense.

    Source: on emissivity and angle, Howell, Menguc and Siegel, Thermal Radiation Heat Transfer
    (2016), chapter 3.
    """
    limit = check_number(
        grazing, where="grazing", quantity="angle to the normal [deg]", above=0.0, most=89.0,
        remedy="give 60 to 75 degrees",
    )  # fmt: skip
    if isinstance(margin, bool) or not isinstance(margin, int | np.integer) or margin < 0:
        raise InputError(
            "this is no margin", where="margin", value=margin,
            limit="a whole number of pixels, 0 or more",
            remedy="give 1 to 3",
        )  # fmt: skip
    steep = np.cos(np.radians(limit))
    with np.errstate(invalid="ignore"):
        seen = pixel_map.cosine > steep
    edge = (pixel_map.triangle < 0) | _jumps(camera, surface, pixel_map, steep)
    if margin:
        square = np.ones((2 * margin + 1,) * 2, bool)
        # Beyond the frame the object goes on unseen: that is no edge of it.
        edge = ndimage.binary_dilation(edge, square)
    return seen & np.logical_not(edge)


def _jumps(
    camera: Camera, surface: Surface, pixel_map: PixelMap, steep: float
) -> Bool[np.ndarray, "rows columns"]:
    places = places_of(surface, pixel_map)
    pitch = pixel_map.depth / camera.focal.min()
    jumps = np.zeros(pixel_map.triangle.shape, bool)
    for axis in (0, 1):
        apart = np.linalg.norm(np.diff(places, axis=axis), axis=-1)
        first = [slice(None)] * 2
        second = [slice(None)] * 2
        first[axis], second[axis] = slice(None, -1), slice(1, None)
        allowed = np.fmax(pitch[tuple(first)], pitch[tuple(second)]) * _JUMP / steep
        with np.errstate(invalid="ignore"):
            wide = apart > allowed
        jumps[tuple(first)] |= wide
        jumps[tuple(second)] |= wide
    return jumps
