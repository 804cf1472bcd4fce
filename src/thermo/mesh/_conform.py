"""Moving the boundary of a mesh so that it holds what its surface holds."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Float

from ._gate import LEAST_QUALITY
from ._geometry import face_areas, mean_ratio
from ._locate import nearest_triangle
from ._mesh import Mesh
from ._surface import Surface

FLAT: Final = 0.1
"""Directions count as a node's own where its faces turn towards them by more than this share [1]
of the most: some 17 degrees to both sides."""

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
    function. Summed over the nodes that closes the volume between the two. Flat parts stay as they
    are, a node on a bent part moves along its normal, one on an edge or a corner also across it.

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
    square, right = np.zeros((len(nodes), 3, 3)), np.zeros((len(nodes), 3))
    for corner in range(3):
        planes = each[:, corner, None, None] * normals[:, :, None] * normals[:, None, :]
        np.add.at(square, faces[:, corner], planes)
        np.add.at(right, faces[:, corner], gap[:, corner, None] * normals)
    values, vectors = np.linalg.eigh(square)
    open_ = values > FLAT * values[:, -1:]
    inverse = np.where(open_, 1.0 / np.where(open_, values, 1.0), 0.0)
    along = np.einsum("nji,nj->ni", vectors, right)
    return np.einsum("nij,nj->ni", vectors, inverse * along)


def _shape_functions() -> Float[np.ndarray, "points 3"]:
    """Of a triangle's corners, at three points of each of the four triangles that halves make.

    With equal weights the sum over them is exact for polynomials of degree two.
    """
    inner = np.full((3, 3), 1 / 6) + np.eye(3) / 2
    middle = (1.0 - np.eye(3)) / 2
    corner = [(inner + np.eye(3)[k]) / 2 for k in range(3)]
    return np.concatenate([*corner, inner @ middle])
