"""Checking a surface, and repairing it where that needs no guess."""

from __future__ import annotations

import numpy as np

from thermo.errors import InputError

from ._bodies import outward
from ._edges import open_sides
from ._repair import distinct_triangles, filled_holes, merged_vertices
from ._self_intersection import crossing_pairs
from ._surface import Surface
from ._winding import consistent_winding


def check_surface(
    surface: Surface, *, where: str, largest: float | int = 2.0, smallest: float | int = 1e-4
) -> Surface:
    """A surface that can be meshed: closed, turned outward, of believable size.

    Coinciding vertices are merged, triangles without three different corners and doubled ones
    dropped, the winding made alike and outward, and holes of at most a hundredth of the area
    filled.

    Arguments:
    - `where`: what to call the surface in messages, such as its file.
    - `largest`, `smallest`: limits of the longest side of the box [m].

    Raises `InputError` where the surface is empty, not finite, of unlikely size, open, one-sided,
    self-intersecting, or has parts turned the wrong way.
    """
    vertices, triangles = _checked_arrays(surface, where)
    _require_size(vertices[np.unique(triangles)], where, largest, smallest)
    vertices, triangles = merged_vertices(vertices, triangles)
    triangles = distinct_triangles(triangles)
    if len(triangles) == 0:
        raise _empty(where, "only triangles without area")
    triangles, body = consistent_winding(triangles, where=where)
    if len(open_sides(triangles)):
        vertices, triangles = filled_holes(vertices, triangles)
        _require_closed(vertices, triangles, where)
        triangles, body = consistent_winding(triangles, where=where)
    triangles = outward(vertices, triangles, body, where=where)
    _require_no_crossing(vertices, triangles, where)
    return Surface(*_without_gaps(vertices, triangles))


def _empty(where: str, value: str) -> InputError:
    return InputError(
        "the surface is empty",
        where=where,
        value=value,
        limit="at least 4 triangles",
        remedy="export the object as a closed triangle surface",
    )


def _checked_arrays(surface: Surface, where: str) -> tuple[np.ndarray, np.ndarray]:
    vertices, triangles = np.asarray(surface.vertices, float), np.asarray(surface.triangles)
    if len(triangles) == 0 or len(vertices) == 0:
        raise _empty(where, f"{len(vertices)} vertices, {len(triangles)} triangles")
    for name, array in (("vertices", vertices), ("triangles", triangles)):
        if array.ndim != 2 or array.shape[1] != 3:
            raise InputError(
                f"the {name} have the wrong shape",
                where=where,
                value=f"shape {array.shape}",
                limit=f"shape ({name}, 3)",
                remedy="give three columns",
            )
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise InputError(
            "a triangle names a vertex that is not there",
            where=where,
            value=f"numbers from {triangles.min()} to {triangles.max()}",
            limit=f"0 to {len(vertices) - 1}",
            remedy="count the vertices from 0",
        )
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if bad.size:
        raise InputError(
            "a vertex is not finite",
            where=where,
            value=f"vertex {bad[0]}: {vertices[bad[0]].tolist()} ({bad.size} in all)",
            limit="finite coordinates",
            remedy="remove or repair these vertices",
        )
    return vertices, triangles.astype(np.int64)


def _require_size(
    vertices: np.ndarray, where: str, largest: float | int, smallest: float | int
) -> None:
    """Refuse a body whose longest side cannot be right, with a guess at the unit."""
    longest = float(np.ptp(vertices, axis=0).max())
    if smallest <= longest <= largest:
        return
    guess = f"check the unit, or set the limits if {longest:g} m is right"
    if longest > largest:
        for factor, name, unit in ((1e-3, "millimetres", "mm"), (1e-2, "centimetres", "cm")):
            if smallest <= factor * longest <= largest:
                guess = f"looks like {name}; state unit={unit}"
                break
    elif smallest <= 1e3 * longest <= largest:
        guess = "looks like metres scaled down; state unit=m, or scale the surface"
    raise InputError(
        "the size is not believable",
        where=where,
        value=f"longest side {longest:g} m",
        limit=f"{smallest:g} to {largest:g} m",
        remedy=guess,
    )


def _require_closed(vertices: np.ndarray, triangles: np.ndarray, where: str) -> None:
    rest = open_sides(triangles)
    if len(rest):
        near = vertices[rest[0]].mean(axis=0)
        raise InputError(
            "the surface is open",
            where=where,
            value=f"{len(rest)} open edges, one near {near.round(5).tolist()} m",
            limit="closed, or holes of at most 1 % of the area",
            remedy="close the holes in a mesh editor",
        )


def _require_no_crossing(vertices: np.ndarray, triangles: np.ndarray, where: str) -> None:
    pairs = crossing_pairs(vertices, triangles)
    if len(pairs):
        near = vertices[triangles[pairs[0, 0]]].mean(axis=0)
        raise InputError(
            "the surface passes through itself",
            where=where,
            value=f"{len(pairs)} pairs of triangles, one near {near.round(5).tolist()} m",
            limit="no crossing triangles",
            remedy="repair it in a mesh editor (boolean union)",
        )


def _without_gaps(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Drop vertices that no triangle uses."""
    used, inverse = np.unique(triangles, return_inverse=True)
    return vertices[used], inverse.reshape(-1, 3).astype(np.int32)
