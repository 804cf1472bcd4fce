"""Between linear and quadratic tetrahedra."""

from __future__ import annotations

import numpy as np

from ._mesh import Mesh
from ._topology import EDGES, face_columns


def promote(mesh: Mesh) -> Mesh:
    """TET4 to TET10: a node in the middle of every edge; edges stay straight.

    The corner nodes keep their numbers, the faces keep their order. A TET10 mesh is returned as
    it is.
    """
    if mesh.order == 2:
        return mesh
    ends = np.sort(mesh.cells[:, EDGES].reshape(-1, 2).astype(np.int64), axis=1)
    keys, middle = np.unique(ends[:, 0] * len(mesh.nodes) + ends[:, 1], return_inverse=True)
    first, second = np.divmod(keys, len(mesh.nodes))
    nodes = np.concatenate([mesh.nodes, 0.5 * (mesh.nodes[first] + mesh.nodes[second])])
    middle = middle.reshape(len(mesh.cells), 6) + len(mesh.nodes)
    cells = np.concatenate([mesh.cells, middle], axis=1).astype(np.int32)
    faces = _faces_like(mesh, cells, 2)
    return Mesh(nodes, cells, faces, mesh.owners, mesh.normals, mesh.regions)


def linear(mesh: Mesh) -> Mesh:
    """TET10 back to TET4: the middle nodes are dropped.

    Corner nodes keep their order, and their numbers where the mesh came from `promote`. A TET4
    mesh is returned as it is.
    """
    if mesh.order == 1:
        return mesh
    used, corners = np.unique(mesh.cells[:, :4], return_inverse=True)
    cells = corners.reshape(-1, 4).astype(np.int32)
    renumber = np.zeros(len(mesh.nodes), np.int32)
    renumber[used] = np.arange(len(used), dtype=np.int32)
    faces = renumber[mesh.faces[:, :3]]
    return Mesh(mesh.nodes[used], cells, faces, mesh.owners, mesh.normals, mesh.regions)


def _faces_like(mesh: Mesh, cells: np.ndarray, order: int) -> np.ndarray:
    """The boundary faces of `mesh` with the nodes that `cells` has, corners in the same turn."""
    candidates = cells[mesh.owners][:, face_columns(order)]
    same = np.sort(candidates[:, :, :3], axis=2) == np.sort(mesh.faces[:, None, :3], axis=2)
    local = np.argmax(same.all(axis=2), axis=1)
    return candidates[np.arange(len(local)), local].astype(np.int32)
