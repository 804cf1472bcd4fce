"""Repairing what can be repaired without guessing at the shape."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from ._edges import open_sides

SAME: Final = 1e-7
"""Distance below which two vertices are one, over the box diagonal."""

SMALL_HOLE: Final = 0.01
"""Largest hole that is filled, as its flat area over the area of the surface."""


def merged_vertices(
    vertices: Float[np.ndarray, "vertices 3"], triangles: Int[np.ndarray, "triangles 3"]
) -> tuple[Float[np.ndarray, "merged 3"], Int[np.ndarray, "triangles 3"]]:
    """One vertex in place of those that coincide; vertices in no triangle are dropped."""
    used, inverse = np.unique(triangles, return_inverse=True)
    vertices, triangles = vertices[used], inverse.reshape(-1, 3)
    reach = SAME * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    pairs = KDTree(vertices).query_pairs(reach, output_type="ndarray")
    if len(pairs) == 0:
        return vertices, triangles
    size = len(vertices)
    graph = csr_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(size, size))
    group = connected_components(graph, directed=False)[1]
    _, first, number = np.unique(group, return_index=True, return_inverse=True)
    # Keep the order of the vertices, so that an intact surface comes back as it was.
    rank = np.argsort(np.argsort(first))
    return vertices[np.sort(first)], rank[number][triangles]


def distinct_triangles(
    triangles: Int[np.ndarray, "triangles 3"],
) -> Int[np.ndarray, "kept 3"]:
    """Triangles with three different corners, each once, in their order."""
    ordered = np.sort(triangles, axis=1)
    whole = (ordered[:, 0] != ordered[:, 1]) & (ordered[:, 1] != ordered[:, 2])
    triangles, ordered = triangles[whole], ordered[whole]
    if len(triangles) == 0:
        return triangles
    _, first = np.unique(ordered, axis=0, return_index=True)
    return triangles[np.sort(first)]


def hole_loops(triangles: Int[np.ndarray, "triangles 3"]) -> list[list[int]]:
    """Closed loops of open sides, each in the turn that its filling needs.

    Sides that do not form simple loops are left out; the triangles must be turned alike.
    """
    after: dict[int, list[int]] = {}
    for start, end in open_sides(triangles).tolist():
        after.setdefault(end, []).append(start)
    loops, seen = [], set()
    for seed in after:
        if seed in seen:
            continue
        loop, here = [], seed
        while here not in seen and len(after.get(here, [])) == 1:
            seen.add(here)
            loop.append(here)
            here = after[here][0]
        if here == seed and len(loop) > 2:
            loops.append(loop)
    return loops


def filled_holes(
    vertices: Float[np.ndarray, "vertices 3"], triangles: Int[np.ndarray, "triangles 3"]
) -> tuple[Float[np.ndarray, "after 3"], Int[np.ndarray, "closed 3"]]:
    """Close every small hole by a triangle, or by a fan around its middle."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    points, added = [vertices], [triangles]
    count = len(vertices)
    for loop in hole_loops(triangles):
        rim = vertices[loop]
        middle = rim.mean(axis=0)
        spokes = np.cross(rim - middle, np.roll(rim, -1, axis=0) - middle)
        if 0.5 * np.linalg.norm(spokes, axis=1).sum() > SMALL_HOLE * area:
            continue
        if len(loop) == 3:
            added.append(np.array([loop]))
            continue
        fan = np.column_stack([loop, np.roll(loop, -1), np.full(len(loop), count)])
        points.append(middle[None])
        added.append(fan)
        count += 1
    return np.concatenate(points), np.concatenate(added)
