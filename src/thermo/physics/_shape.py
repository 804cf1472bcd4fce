"""Shape functions of straight tetrahedra and triangles with 4 or 10, 3 or 6 nodes."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

CELL_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
FACE_EDGES = ((0, 1), (1, 2), (2, 0))


def _shape(
    barycentric: Float[np.ndarray, "points corners"], edges: tuple[tuple[int, int], ...]
) -> Float[np.ndarray, "points nodes"]:
    corners = barycentric * (2 * barycentric - 1)
    mids = [4 * barycentric[:, a] * barycentric[:, b] for a, b in edges]
    return np.concatenate([corners, np.stack(mids, 1)], 1)


def face_shape(
    barycentric: Float[np.ndarray, "points 3"], order: int
) -> Float[np.ndarray, "points nodes"]:
    """Values [1] of the 3 (order 1) or 6 (order 2) shape functions of a face at given points."""
    return barycentric if order == 1 else _shape(barycentric, FACE_EDGES)


def cell_shape(
    barycentric: Float[np.ndarray, "points 4"], order: int
) -> Float[np.ndarray, "points nodes"]:
    """Values [1] of the 4 (order 1) or 10 (order 2) shape functions of a cell at given points."""
    return barycentric if order == 1 else _shape(barycentric, CELL_EDGES)


def cell_shape_gradient(
    barycentric: Float[np.ndarray, "points 4"], order: int
) -> Float[np.ndarray, "points nodes 4"]:
    """Derivatives [1] of the cell's shape functions by the four barycentric coordinates."""
    count = len(barycentric)
    if order == 1:
        return np.broadcast_to(np.eye(4), (count, 4, 4)).copy()
    gradient = np.zeros((count, 10, 4))
    for a in range(4):
        gradient[:, a, a] = 4 * barycentric[:, a] - 1
    for row, (a, b) in enumerate(CELL_EDGES, start=4):
        gradient[:, row, a] = 4 * barycentric[:, b]
        gradient[:, row, b] = 4 * barycentric[:, a]
    return gradient


def reference_mass(order: int) -> Float[np.ndarray, "nodes nodes"]:
    """Mass matrix [1] of a cell of unit volume: the integral of N_i N_j."""
    from thermo.physics._quadrature import tetrahedron_rule

    points, weights = tetrahedron_rule(2 * order)
    shape = cell_shape(points, order)
    return np.einsum("q,qi,qj->ij", weights, shape, shape)


def reference_stiffness(order: int) -> Float[np.ndarray, "nodes nodes 4 4"]:
    """Integral [1] of (dN_i/dL_a)(dN_j/dL_b) over a cell of unit volume.

    With g_a the gradient of the barycentric coordinate L_a [1/m], a cell of volume V has
    K_ij = V sum_ab S_ijab g_a . D g_b: straight cells need no quadrature of their own.
    """
    from thermo.physics._quadrature import tetrahedron_rule

    points, weights = tetrahedron_rule(max(2 * (order - 1), 1))
    gradient = cell_shape_gradient(points, order)
    return np.einsum("q,qia,qjb->ijab", weights, gradient, gradient)
