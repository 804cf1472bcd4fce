"""Vertices that a surface would be the same without."""

from __future__ import annotations

from typing import Final

import numpy as np

from ._geometry import triangle_normals
from ._surface import Surface

TURNED: Final = 1e-6
"""Directions count as one where normals turn out of their plane by less, by eigenvalues [1]: a
thousandth of a radian."""


def needless_share(surface: Surface) -> float:
    """Share [1] of the vertices within flat faces and straight edges.

    The triangles around such a vertex lie in two planes at the most, so that their unit normals n,
    weighted by areas A, have sum A n n^T of rank two or one.
    """
    normals, areas = triangle_normals(surface.vertices, surface.triangles)
    around = np.zeros((len(surface.vertices), 3, 3))
    each = areas[:, None, None] * normals[:, :, None] * normals[:, None, :]
    for corner in surface.triangles.T:
        np.add.at(around, corner, each)
    least, _, most = np.linalg.eigvalsh(around).T
    return float(np.mean(least <= TURNED * most))
