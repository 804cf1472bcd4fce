"""Moving the boundary of a mesh so that it holds what its surface holds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from jaxtyping import Float

from ._gate import LEAST_QUALITY
from ._geometry import face_areas, mean_ratio
from ._mesh import Mesh
from ._nearest_triangle import nearest_triangle
from ._surface import Surface

FLAT: Final = 0.1
"""Directions count as a node's own where its faces turn towards them by more than this share [1]
of the most: some 17 degrees to both sides."""

THERE: Final = 1e-6
"""A face that is nowhere farther off, over the root of its area [1], stays in its plane."""

TURNED: Final = 1e-6
"""Planes of such faces of one node that turn by less count as one [1], by eigenvalues as above."""

LEAST_KEPT: Final = 0.5
"""Nodes of a cell that would keep less than this share of its mean ratio stay [1], or would become
too flat for the gate."""


def conformed(mesh: Mesh, surface: Surface) -> Float[np.ndarray, "nodes 3"]:
    """Nodes [m] of a mesh moved so that its faces lie on both sides of the surface alike.

    A mesher puts the corners of faces on the surface or close to it. Where that is curved outward
    all else of a face lies within: the mesh holds too little and heats up too fast, so that a fit
    finds too large a capacity. Each node on the boundary moves by the u that minimises, over the
    faces f around it with normals n,

        sum_f int_f N (n . u - d)^2 dA,

    d the signed distance from the face to the surface along n and N the node's linear shape
    function. Summed over the nodes that closes the volume between the two. Faces that lie on flat
    parts stay in their planes; a node on a bent part moves along its normal, one on an edge or a
    corner also across it.

    Arguments: `mesh`: linear cells; `surface`: what it was made from [m].

    Source: the quadric of Garland and Heckbert, SIGGRAPH 97, 209, weighted by shape functions.
    """
    before, moves = mean_ratio(mesh.nodes, mesh.cells), _moves(mesh, surface)
    least = np.maximum(LEAST_KEPT * before, np.minimum(before, LEAST_QUALITY))
    while True:
        worse = mean_ratio(mesh.nodes + moves, mesh.cells) < least
        held = np.unique(mesh.cells[worse])
        if not np.any(moves[held]):
            return mesh.nodes + moves
        moves[held] = 0.0


def _moves(mesh: Mesh, surface: Surface) -> Float[np.ndarray, "nodes 3"]:
    """What each node moves by [m]."""
    nodes, faces = mesh.nodes, mesh.faces
    shape = _shape_functions()
    points = np.einsum("pk,fki->fpi", shape, nodes[faces])
    corners = surface.vertices[surface.triangles]
    triangle, share, _ = nearest_triangle(corners, points.reshape(-1, 3))
    closest = np.einsum("pk,pki->pi", share, corners[triangle]).reshape(points.shape)
    normals, areas = mesh.normals, face_areas(mesh)
    apart = np.einsum("fpi,fi->fp", closest - points, normals)
    weight = areas[:, None] / len(shape)
    # By face and corner: the integrals of N and of N d.
    each = weight * shape.sum(axis=0)
    gap = weight * (apart @ shape)
    there = np.abs(apart).max(axis=1) < THERE * np.sqrt(areas)
    square, right = np.zeros((len(nodes), 3, 3)), np.zeros((len(nodes), 3))
    kept = np.zeros((len(nodes), 3, 3))
    for corner in range(3):
        planes = each[:, corner, None, None] * normals[:, :, None] * normals[:, None, :]
        np.add.at(square, faces[:, corner], planes)
        np.add.at(right, faces[:, corner], gap[:, corner, None] * normals)
        np.add.at(kept, faces[there, corner], planes[there])
    # Along the planes of faces that are where they should be; what they turn by is no direction.
    free = np.eye(3) - _onto(kept, TURNED * np.trace(kept, axis1=1, axis2=2), np.ones_like)
    least = FLAT * np.linalg.eigvalsh(square)[:, -1]
    inverse = _onto(free @ square @ free, least, np.reciprocal)
    return np.einsum("nij,njk,nk->ni", inverse, free, right)


def _onto(
    square: Float[np.ndarray, "nodes 3 3"],
    least: Float[np.ndarray, " nodes"],
    of: Callable[[np.ndarray], np.ndarray],
) -> Float[np.ndarray, "nodes 3 3"]:
    """The matrices with a function `of` their eigenvalues where these are above the `least`."""
    values, vectors = np.linalg.eigh(square)
    large = values > np.maximum(least, np.finfo(float).tiny)[:, None]
    made = np.where(large, of(np.where(large, values, 1.0)), 0.0)
    return np.einsum("nij,nj,nkj->nik", vectors, made, vectors)


def _shape_functions() -> Float[np.ndarray, "points 3"]:
    """Of a triangle's corners, at three points of each of the four triangles that halves make.

    With equal weights the sum over them is exact for polynomials of degree two.
    """
    inner = np.full((3, 3), 1 / 6) + np.eye(3) / 2
    middle = (1.0 - np.eye(3)) / 2
    corner = [(inner + np.eye(3)[k]) / 2 for k in range(3)]
    return np.concatenate([*corner, inner @ middle])
