"""Structured mesh of a ball."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import ConvexHull

from ._build import mesh_from_cells
from ._mesh import Mesh
from ._structured import lattice_cells, require_positive


def ball_mesh(radius: float | int, shells: int) -> Mesh:
    """TET4 mesh of a ball about the origin.

    The twenty tetrahedra between the centre and the faces of an icosahedron are divided
    `shells` times along each edge; every shell of nodes is then moved to its sphere. The outer
    nodes lie on the sphere of `radius`, the faces between them inside it.

    Arguments:
    - `radius`: [m].
    - `shells`: cells along the radius.

    Raises `InputError` for numbers that are not positive.
    """
    require_positive("radius", radius)
    require_positive("shells", shells)
    directions, faces = _icosahedron()
    lattice, cells = _divided_simplex(shells)
    # Whole-number weights of the centre and the twelve corners name a node without rounding.
    steps = np.column_stack([lattice, np.zeros(len(lattice), int)])
    weights = np.zeros((20, len(lattice), 13), np.int64)
    for face, corners in enumerate(faces):
        weights[face, :, 0] = shells - lattice[:, 0]
        for place, corner in enumerate(corners):
            weights[face, :, 1 + corner] = steps[:, place] - steps[:, place + 1]
    unique, number = np.unique(weights.reshape(-1, 13), axis=0, return_inverse=True)
    number = number.reshape(20, len(lattice))
    flat = unique[:, 1:] @ directions
    length = np.linalg.norm(flat, axis=1)
    share = unique[:, 1:].sum(axis=1) / shells
    nodes = radius * flat * (share / np.where(length > 0.0, length, 1.0))[:, None]
    return mesh_from_cells(nodes, number[:, cells].reshape(-1, 4), where="ball_mesh")


def _icosahedron() -> tuple[Float[np.ndarray, "12 3"], Int[np.ndarray, "20 3"]]:
    """Unit corners and faces of an icosahedron."""
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    base = np.array([(0.0, i, j * golden) for i in (-1, 1) for j in (-1, 1)])
    corners = np.concatenate([np.roll(base, shift, axis=1) for shift in range(3)])
    corners /= np.linalg.norm(corners[0])
    return corners, ConvexHull(corners).simplices


def _divided_simplex(parts: int) -> tuple[Int[np.ndarray, "nodes 3"], Int[np.ndarray, "cells 4"]]:
    """Kuhn's split of the lattice restricted to parts >= x >= y >= z >= 0."""
    shape = (parts + 1, parts + 1, parts + 1)
    lattice = np.stack(list(np.indices(shape)), axis=-1).reshape(-1, 3)
    inside = (lattice[:, 0] >= lattice[:, 1]) & (lattice[:, 1] >= lattice[:, 2])
    cells = lattice_cells(shape)
    cells = cells[inside[cells].all(axis=1)]
    renumber = np.cumsum(inside) - 1
    return lattice[inside], renumber[cells]
