"""The tetrahedral mesh that everything else stands on."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Float, Int


@final
class Mesh(eqx.Module):
    """A validated mesh of straight-edged tetrahedra with its boundary.

    Make one with `mesh_from_cells`, `tetrahedralise` or a structured generator; the class itself
    checks nothing. All leaves are NumPy arrays.

    Arguments:
    - `nodes`: (nodes, 3) positions [m].
    - `cells`: (cells, 4) or (cells, 10) node numbers in VTK's order; every volume is positive.
    - `faces`: (faces, 3) or (faces, 6) boundary faces, corners turning outward.
    - `owners`: (faces,) the one cell behind each boundary face.
    - `normals`: (faces, 3) outward unit normals; of faces as good as parallel to a surface that
      was meshed those of the surface.
    - `regions`: (cells,) number of the material region of each cell.
    """

    nodes: Float[np.ndarray, "nodes 3"]
    cells: Int[np.ndarray, "cells per_cell"]
    faces: Int[np.ndarray, "faces per_face"]
    owners: Int[np.ndarray, " faces"]
    normals: Float[np.ndarray, "faces 3"]
    regions: Int[np.ndarray, " cells"]

    @property
    def order(self) -> int:
        """Degree of the shape functions: 1 for TET4, 2 for TET10."""
        return 1 if self.cells.shape[1] == 4 else 2

    @property
    def surface_nodes(self) -> Int[np.ndarray, " surface"]:
        """Sorted numbers of the nodes on the boundary."""
        return np.unique(self.faces)

    def volume(self) -> float:
        """Volume of the body [m3]."""
        corners = self.nodes[self.cells[:, :4]]
        return float(np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6.0)

    def area(self) -> float:
        """Area of the boundary [m2]."""
        a, b, c = (self.nodes[self.faces[:, i]] for i in range(3))
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
