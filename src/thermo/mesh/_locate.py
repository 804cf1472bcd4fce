"""Binding points to the boundary of a mesh."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Float, Int

from thermo.errors import InputError

from ._mesh import Mesh
from ._nearest_triangle import nearest_triangle


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
