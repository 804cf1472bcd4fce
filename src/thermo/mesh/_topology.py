"""Local numbering of the tetrahedra and triangles, the same as VTK's.

A ten-node tetrahedron has its corners first, then the middles of the edges 01 12 02 03 13 23.
A six-node triangle has its corners first, then the middles of the edges 01 12 20.
"""

from __future__ import annotations

from typing import Final

import numpy as np

EDGES: Final = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
"""Corners of the six edges of a cell, in the order of the middle nodes."""

CELL_FACES: Final = np.array(
    [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]]
)
"""Local nodes of the four faces of a cell of positive volume, turned outward."""

FLIP: Final = np.array([0, 2, 1, 3, 6, 5, 4, 7, 9, 8])
"""Local renumbering that turns a cell of negative volume into one of positive volume."""


def face_columns(order: int) -> np.ndarray:
    """Local nodes of the four faces of a cell: (4, 3) for order 1, (4, 6) for order 2."""
    return CELL_FACES[:, : 3 * order]


def nodes_per_cell(order: int) -> int:
    """Number of nodes of a cell: 4 for order 1, 10 for order 2."""
    return 4 if order == 1 else 10
