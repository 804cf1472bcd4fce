"""How thick a body is, measured through its inside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from jaxtyping import Float, Int

from ._geometry import triangle_normals
from ._surface import Surface


def spread_triangles(areas: Float[np.ndarray, " triangles"], count: int) -> Int[np.ndarray, " c"]:
    """At most `count` triangles chosen evenly by area along their list, without chance."""
    share = np.cumsum(areas) / areas.sum()
    return np.unique(np.searchsorted(share, (np.arange(count) + 0.5) / count))


@final
@dataclass(frozen=True)
class InwardRays:
    """Rays from triangle centres straight into the body, as far as the opposite wall.

    Arguments:

    - `starts`: (rays, 3) [m]; `directions`: (rays, 3) unit vectors.
    - `lengths`: (rays,) thickness of the body along each ray [m].
    """

    starts: Float[np.ndarray, "rays 3"]
    directions: Float[np.ndarray, "rays 3"]
    lengths: Float[np.ndarray, " rays"]


def inward_rays(surface: Surface, *, rays: int = 400) -> InwardRays:
    """Measure how thick a body is by rays [m] spread over its surface.

    Rays meet triangles by the test of Moeller and Trumbore, J. Graphics Tools 2 (1997) 21-28.
    Rays that meet nothing are left out.
    """
    normals, areas = triangle_normals(surface.vertices, surface.triangles)
    chosen = spread_triangles(areas, rays)
    corners = surface.vertices[surface.triangles]
    starts, directions = corners[chosen].mean(axis=1), -normals[chosen]
    lengths = np.array(
        [_reach(corners, start, along) for start, along in zip(starts, directions, strict=True)]
    )
    met = np.isfinite(lengths)
    return InwardRays(starts[met], directions[met], lengths[met])


def _reach(corners: np.ndarray, start: np.ndarray, along: np.ndarray) -> float:
    """Distance from `start` to the first wall that `along` leaves by, infinite without one."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(along, v)
    determinant = np.einsum("ij,ij->i", u, across)
    # Only walls that face the ray can be where it leaves the body.
    facing = np.flatnonzero(determinant < 0.0)
    offset, inverse = start - corners[facing, 0], 1.0 / determinant[facing]
    first = np.einsum("ij,ij->i", offset, across[facing]) * inverse
    turn = np.cross(offset, u[facing])
    second = turn @ along * inverse
    reach = np.einsum("ij,ij->i", turn, v[facing]) * inverse
    hit = (first >= 0.0) & (second >= 0.0) & (first + second <= 1.0) & (reach > 0.0)
    return float(reach[hit].min()) if hit.any() else np.inf
