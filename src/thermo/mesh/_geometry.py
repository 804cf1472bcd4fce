"""Areas, volumes and quality of cells and faces."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from ._mesh import Mesh
from ._topology import EDGES


def signed_volumes(
    nodes: Float[np.ndarray, "nodes 3"], cells: Int[np.ndarray, "cells per_cell"]
) -> Float[np.ndarray, " cells"]:
    """Volumes det(x1 - x0, x2 - x0, x3 - x0) / 6 [m3]; negative where a cell is inside out."""
    a, b, c, d = (nodes[cells[:, i]] for i in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0


def squared_edges(
    nodes: Float[np.ndarray, "nodes 3"], cells: Int[np.ndarray, "cells per_cell"]
) -> Float[np.ndarray, "cells 6"]:
    """Squared lengths of the six edges of each cell [m2]."""
    ends = nodes[cells[:, EDGES]]
    return ((ends[:, :, 1] - ends[:, :, 0]) ** 2).sum(axis=-1)


def mean_ratio(
    nodes: Float[np.ndarray, "nodes 3"], cells: Int[np.ndarray, "cells per_cell"]
) -> Float[np.ndarray, " cells"]:
    """Mean ratio q = 12 (3 V)^(2/3) / sum of squared edges, with the sign of V."""
    volumes = signed_volumes(nodes, cells)
    edges = squared_edges(nodes, cells).sum(axis=1)
    size = 12.0 * np.cbrt(3.0 * np.abs(volumes)) ** 2
    return np.sign(volumes) * size / np.maximum(edges, np.finfo(float).tiny)


def triangle_normals(
    vertices: Float[np.ndarray, "vertices 3"], triangles: Int[np.ndarray, "triangles corners"]
) -> tuple[Float[np.ndarray, "triangles 3"], Float[np.ndarray, " triangles"]]:
    """Unit normals and areas [m2] of triangles given by their first three columns.

    The normal of a triangle without area is zero.
    """
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    cross = np.cross(b - a, c - a)
    double = np.linalg.norm(cross, axis=1)
    return cross / np.where(double > 0.0, double, 1.0)[:, None], 0.5 * double


def face_areas(mesh: Mesh) -> Float[np.ndarray, " faces"]:
    """Areas of the boundary faces [m2]."""
    return triangle_normals(mesh.nodes, mesh.faces)[1]


def cell_volumes(mesh: Mesh) -> Float[np.ndarray, " cells"]:
    """Volumes of the cells [m3], all positive."""
    return signed_volumes(mesh.nodes, mesh.cells)


def cell_quality(mesh: Mesh) -> Float[np.ndarray, " cells"]:
    """Mean ratio [1] of each cell, in (0, 1]: 1 for a regular one, towards 0 for a flat one.

    q = 12 (3 V)^(2/3) / (l1^2 + ... + l6^2), after Liu and Joe, BIT 34 (1994) 268-287.
    """
    return mean_ratio(mesh.nodes, mesh.cells)
