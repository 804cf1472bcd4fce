"""Fewer triangles for the mesher."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np

from thermo.errors import InputError

from ._check_surface import check_surface
from ._surface import Surface


def simplified(surface: Surface, *, most: int, target: int, where: str) -> Surface:
    """A surface of at most `most` triangles [1]: the given one, or one brought down to `target`.

    Edges are collapsed by quadric errors, but none whose collapse would make triangles cross or the
    surface open. Vertices stay in [m].

    Raises `InputError` for a finer surface where the optional package libigl is missing or its
    result is not a surface that can be meshed.

    Source: Garland and Heckbert, SIGGRAPH 1997; libigl's `qslim`.
    """
    if len(surface.triangles) <= most:
        return surface
    if find_spec("igl") is None:
        raise InputError(
            "the surface is too fine for the mesher", where=where,
            value=f"{len(surface.triangles)} triangles", limit=f"{most} triangles",
            remedy="decimate it in a mesh editor, or install the package libigl",
        )  # fmt: skip
    import igl

    vertices, triangles, *_ = igl.qslim(
        surface.vertices, surface.triangles.astype(np.int32), target, True
    )
    longest = float(np.ptp(surface.vertices, axis=0).max())
    return check_surface(
        Surface(np.asarray(vertices, float), np.asarray(triangles, np.int64)),
        where=f"{where} (simplified)", largest=2.0 * longest, smallest=0.5 * longest,
    )  # fmt: skip
