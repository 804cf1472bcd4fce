"""Structured mesh of a cylinder."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from ._build import mesh_from_cells
from ._mesh import Mesh
from ._structured import require_positive


def cylinder_mesh(radius: float | int, length: float | int, rings: int, layers: int) -> Mesh:
    """TET4 mesh of a cylinder along z from 0 to `length`.

    The nodes of the side lie on the circle of `radius`, so the volume is that of the inscribed
    prism with 6 `rings` sides.

    Arguments:
    - `radius`, `length`: [m].
    - `rings`: cells along the radius; ring k has 6 k nodes.
    - `layers`: cells along the axis.

    Raises `InputError` for numbers that are not positive.
    """
    require_positive("radius", radius)
    require_positive("length", length)
    require_positive("rings", rings)
    require_positive("layers", layers)
    disk, triangles = _disk(rings)
    heights = np.linspace(0.0, length, layers + 1)
    nodes = np.concatenate(
        [np.column_stack([radius * disk, np.full(len(disk), z)]) for z in heights]
    )
    # Splitting every prism along its ordered corners makes neighbours agree on their diagonals.
    a, b, c = np.sort(triangles, axis=1).T
    up = len(disk)
    split = [
        np.stack(corners, axis=1)
        for corners in (
            (a, b, c, c + up),
            (a, b, b + up, c + up),
            (a, a + up, b + up, c + up),
        )
    ]
    prism = np.stack(split, axis=1).reshape(-1, 4)
    cells = np.concatenate([prism + layer * up for layer in range(layers)])
    return mesh_from_cells(nodes, cells, where="cylinder_mesh")


def _disk(rings: int) -> tuple[Float[np.ndarray, "nodes 2"], Int[np.ndarray, "triangles 3"]]:
    """Unit disk of concentric rings, ring k with 6 k nodes, and its triangles."""
    points, triangles, start = [np.zeros((1, 2))], [], 0
    for ring in range(1, rings + 1):
        angle = 2.0 * np.pi * np.arange(6 * ring) / (6 * ring)
        points.append(ring / rings * np.column_stack([np.cos(angle), np.sin(angle)]))
        inner, outer = max(6 * (ring - 1), 1), 6 * ring
        first = start + inner
        for sector in range(6):
            for step in range(ring):
                here = start + (sector * (ring - 1) + step) % inner
                near = first + sector * ring + step
                far = first + (sector * ring + step + 1) % outer
                triangles.append((here, near, far))
                if step < ring - 1:
                    beside = start + (sector * (ring - 1) + step + 1) % inner
                    triangles.append((here, far, beside))
        start = first
    return np.concatenate(points), np.array(triangles)
