"""Fewer triangles for the mesher."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Final

import numpy as np
import trimesh

from thermo.errors import InputError

from ._check_surface import check_surface
from ._surface import Surface

MOST_TRIANGLES: Final = 40000
"""Largest surface that is given to the mesher; its time grows steeply beyond."""

TARGET: Final = 20000
"""Triangles that a finer surface is brought down to."""


def simplified(surface: Surface, *, where: str) -> Surface:
    """A surface of at most 40 000 triangles: the given one, or a decimated one.

    Decimation is by quadric errors (Garland and Heckbert, SIGGRAPH 1997) in the optional package
    fast_simplification. Vertices stay in [m].

    Raises `InputError` for a finer surface where the package is missing or its result is not a
    surface that can be meshed.
    """
    if len(surface.triangles) <= MOST_TRIANGLES:
        return surface
    if find_spec("fast_simplification") is None:
        raise InputError(
            "the surface is too fine for the mesher",
            where=where,
            value=f"{len(surface.triangles)} triangles",
            limit=f"{MOST_TRIANGLES} triangles",
            remedy="decimate it in a mesh editor, or install the package fast-simplification",
        )
    full = trimesh.Trimesh(surface.vertices, surface.triangles, process=False)
    less = full.simplify_quadric_decimation(face_count=TARGET)
    vertices, triangles = np.asarray(less.vertices, float), np.asarray(less.faces, np.int64)
    longest = float(np.ptp(surface.vertices, axis=0).max())
    return check_surface(
        Surface(vertices, triangles),
        where=f"{where} (simplified)",
        largest=2.0 * longest,
        smallest=0.5 * longest,
    )
