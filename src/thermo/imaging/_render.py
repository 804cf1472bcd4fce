"""Radiometric pictures: what each pixel of a camera reads off a surface."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError

from ._pixel_map import PixelMap


def render(
    pixel_map: PixelMap, vertex_values: Float[np.ndarray, " vertices"]
) -> Float[np.ndarray, "rows columns"]:
    """One picture, in the unit of the values: T(p) = sum_r lambda_r(p) T_mr; NaN where nothing is.

    Arguments: `vertex_values`, such as temperatures [K], one a vertex of the surface that was
    looked at.

    Raises `InputError` where the surface has another number of vertices.

    Source: paper, appendix A.1, "Thermal Infrared Video Rendering" (checklist F9).
    """
    check_values(pixel_map, len(vertex_values))
    picture = np.full(pixel_map.size(), np.nan)
    first, second, third = pixel_map.corners.T
    share = pixel_map.weights.T
    picture.ravel()[pixel_map.hit] = (
        share[0] * vertex_values[first]
        + share[1] * vertex_values[second]
        + share[2] * vertex_values[third]
    )
    return picture


def check_values(pixel_map: PixelMap, given: int) -> None:
    """Raise `InputError` unless there is one value for each vertex that was looked at."""
    if given != pixel_map.vertices:
        raise InputError(
            "these values are of another surface", where="vertex values",
            value=f"{given} vertices", limit=f"{pixel_map.vertices} vertices, as was looked at",
            remedy="give one value a vertex; bring samples there by `interpolated`",
        )  # fmt: skip
