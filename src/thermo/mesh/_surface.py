"""A closed triangle surface in metres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from jaxtyping import Float, Int

from ._geometry import triangle_normals


@final
@dataclass(frozen=True)
class Surface:
    """A triangle surface; `check_surface` makes it one that can be meshed.

    Arguments:
    - `vertices`: (vertices, 3) positions [m].
    - `triangles`: (triangles, 3) vertex numbers, turning outward once checked.
    """

    vertices: Float[np.ndarray, "vertices 3"]
    triangles: Int[np.ndarray, "triangles 3"]

    def volume(self) -> float:
        """Enclosed volume [m3] by the divergence theorem; positive when turned outward."""
        return float(body_volumes(self.vertices, self.triangles).sum())

    def area(self) -> float:
        """Area [m2]."""
        return float(triangle_normals(self.vertices, self.triangles)[1].sum())

    def diagonal(self) -> float:
        """Diagonal of the bounding box [m]."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))


def body_volumes(
    vertices: Float[np.ndarray, "vertices 3"], triangles: Int[np.ndarray, "triangles 3"]
) -> Float[np.ndarray, " triangles"]:
    """Signed volume between each triangle and the centre of the vertices [m3]."""
    shifted = vertices - vertices.mean(axis=0)
    a, b, c = (shifted[triangles[:, i]] for i in range(3))
    return np.einsum("ij,ij->i", np.cross(a, b), c) / 6.0
