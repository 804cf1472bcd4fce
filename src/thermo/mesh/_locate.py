"""Binding points to the boundary of a mesh."""

from __future__ import annotations

from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from thermo.errors import InputError

from ._geometry import triangle_normals
from ._mesh import Mesh
from ._nearest import closest_on_triangles

LARGEST_BATCH: Final = 400000
"""Most pairs of point and triangle that are tried at once, to bound the memory."""


@final
class SurfacePoints(eqx.Module):
    """Points bound to boundary faces; a nodal field u reads sum_q weights[s, q] u[nodes[s, q]].

    Arguments:
    - `face`: (samples,) the nearest boundary face.
    - `weights`: (samples, 3) or (samples, 6) shape functions of the face's nodes; rows sum to 1.
    - `nodes`: (samples, 3) or (samples, 6) the face's nodes.
    - `distance`: (samples,) distance from the point to its projection [m].
    """

    face: Int[np.ndarray, " samples"]
    weights: Float[np.ndarray, "samples per_face"]
    nodes: Int[np.ndarray, "samples per_face"]
    distance: Float[np.ndarray, " samples"]


def face_weights(
    barycentric: Float[np.ndarray, "samples 3"], order: int
) -> Float[np.ndarray, "samples per_face"]:
    """Shape functions of a triangle with 3 (order 1) or 6 (order 2) nodes.

    Order 2: L_i (2 L_i - 1) at the corners and 4 L_i L_j in the middles of 01, 12, 20.
    """
    if order == 1:
        return barycentric
    corners = barycentric * (2.0 * barycentric - 1.0)
    middles = 4.0 * barycentric * np.roll(barycentric, -1, axis=1)
    return np.concatenate([corners, middles], axis=1)


def locate(mesh: Mesh, points: np.ndarray) -> SurfacePoints:
    """Project points on the nearest boundary face and weigh its nodes.

    The faces are flat (edges are straight), so the projection on the corner triangle is exact.
    Points far away are projected too; the caller judges `distance`.

    Arguments:
    - `points`: (samples, 3) positions [m].

    Raises `InputError` where the points are not finite or not three coordinates each.
    """
    points = np.asarray(points, float)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(
            "the points are not a list of positions",
            where="points",
            value=f"shape {points.shape}",
            limit="shape (samples, 3)",
            remedy="give three coordinates a sample [m]",
        )
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if bad.size:
        raise InputError(
            "a point is not finite",
            where="points",
            value=f"sample {bad[0]}: {points[bad[0]].tolist()}",
            limit="finite coordinates [m]",
            remedy="remove the sample, or give its position",
        )
    corners = mesh.nodes[mesh.faces[:, :3]]
    face, barycentric, distance = nearest_triangle(corners, points)
    weights = face_weights(barycentric, mesh.order)
    return SurfacePoints(face.astype(np.int32), weights, mesh.faces[face], distance)


def nearest_triangle(
    corners: Float[np.ndarray, "triangles 3 3"], points: Float[np.ndarray, "samples 3"]
) -> tuple[
    Int[np.ndarray, " samples"], Float[np.ndarray, "samples 3"], Float[np.ndarray, " samples"]
]:
    """The nearest triangle of each point, its barycentric coordinates there and the distance [m].

    Triangles are searched in classes of like size, so that a few large ones cost little; the
    answer is exact.
    """
    centres = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    classes = np.floor(np.log2(np.maximum(radii, radii.max() * 2.0**-20) / radii.max()))
    loose = np.arange(3 * len(corners)).reshape(-1, 3)
    normals, _ = triangle_normals(corners.reshape(-1, 3), loose)
    face = np.zeros(len(points), np.int64)
    barycentric = np.zeros((len(points), 3))
    distance = np.full(len(points), np.inf)
    for size in np.unique(classes):
        members = np.flatnonzero(classes == size)
        tree = KDTree(centres[members])
        widest = radii[members].max()
        _search(corners, normals, members, tree, widest, points, face, barycentric, distance)
    return face, barycentric, distance


def _search(
    corners: np.ndarray,
    normals: np.ndarray,
    members: np.ndarray,
    tree: KDTree,
    radius: float,
    points: np.ndarray,
    face: np.ndarray,
    barycentric: np.ndarray,
    distance: np.ndarray,
) -> None:
    """Improve the three result arrays in place with the triangles of one size class."""
    open_points, count = np.arange(len(points)), min(8, len(members))
    while open_points.size:
        reach, hits = tree.query(points[open_points], k=count)
        reach, hits = reach.reshape(-1, count), hits.reshape(-1, count)
        parts = len(open_points) * count // LARGEST_BATCH + 1
        for rows in np.array_split(np.arange(len(open_points)), parts):
            chosen, tries = open_points[rows], members[hits[rows]]
            # Long triangles have centres within reach of many points and planes within that of few.
            off = points[chosen][:, None] - corners[tries, 0]
            plane = np.abs(np.einsum("spi,spi->sp", off, normals[tries]))
            row, column = np.nonzero(plane < distance[chosen, None])
            weight, gap = closest_on_triangles(corners[tries[row, column]], points[chosen[row]])
            gaps, at_gap = np.full(tries.shape, np.inf), np.zeros(tries.shape, np.int64)
            gaps[row, column], at_gap[row, column] = gap, np.arange(len(row))
            best, line = np.argmin(gaps, axis=1), np.arange(len(rows))
            better = gaps[line, best] < distance[chosen]
            at, found = chosen[better], at_gap[line, best][better]
            distance[at], barycentric[at] = gap[found], weight[found]
            face[at] = tries[line, best][better]
        # Every triangle not tried yet has its centre beyond the last one tried.
        unsure = reach[:, -1] - radius < distance[open_points]
        open_points = open_points[unsure] if count < len(members) else open_points[:0]
        count = min(4 * count, len(members))
