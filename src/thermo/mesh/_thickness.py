"""How thick a body is, measured through its inside."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from ._geometry import triangle_normals
from ._surface import Surface


def spread_triangles(areas: Float[np.ndarray, " triangles"], count: int) -> Int[np.ndarray, " c"]:
    """At most `count` triangles chosen evenly by area along their list, without chance."""
    share = np.cumsum(areas) / areas.sum()
    return np.unique(np.searchsorted(share, (np.arange(count) + 0.5) / count))


def thicknesses(surface: Surface, *, rays: int = 400) -> Float[np.ndarray, " rays"]:
    """Lengths of inward rays from triangle centres to the opposite wall [m].

    Rays meet triangles by the test of Moeller and Trumbore, J. Graphics Tools 2 (1997) 21-28.
    Rays that meet nothing are left out.
    """
    normals, areas = triangle_normals(surface.vertices, surface.triangles)
    chosen = spread_triangles(areas, rays)
    corners = surface.vertices[surface.triangles]
    starts, directions = corners[chosen].mean(axis=1), -normals[chosen]
    origin, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    found = []
    for start, direction in zip(starts, directions, strict=True):
        across = np.cross(direction, v)
        determinant = np.einsum("ij,ij->i", u, across)
        # Only walls that face the ray can be where it leaves the body.
        facing = np.flatnonzero(determinant < 0.0)
        offset, inverse = start - origin[facing], 1.0 / determinant[facing]
        first = np.einsum("ij,ij->i", offset, across[facing]) * inverse
        turn = np.cross(offset, u[facing])
        second = turn @ direction * inverse
        reach = np.einsum("ij,ij->i", turn, v[facing]) * inverse
        hit = (first >= 0.0) & (second >= 0.0) & (first + second <= 1.0) & (reach > 0.0)
        if hit.any():
            found.append(reach[hit].min())
    return np.array(found)
