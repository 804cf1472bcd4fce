"""Edges of a triangle surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from jaxtyping import Bool, Int


@final
@dataclass(frozen=True)
class EdgeTable:
    """The different edges and the triangle sides that lie on them.

    Side 3 t + i of triangle t runs from its corner i to its corner i + 1.

    Arguments:
    - `edges`: (edges, 2) vertex numbers, ascending in each row.
    - `counts`: (edges,) number of sides on each edge.
    - `starts`: (edges,) where the edge's sides begin in `order`.
    - `order`: (sides,) side numbers, sorted by edge.
    - `forward`: (sides,) whether a side runs from the smaller to the larger vertex number.
    """

    edges: Int[np.ndarray, "edges 2"]
    counts: Int[np.ndarray, " edges"]
    starts: Int[np.ndarray, " edges"]
    order: Int[np.ndarray, " sides"]
    forward: Bool[np.ndarray, " sides"]


def directed_sides(triangles: Int[np.ndarray, "triangles 3"]) -> Int[np.ndarray, "sides 2"]:
    """The sides 01, 12, 20 of every triangle, one after the other."""
    return triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).astype(np.int64)


def edge_table(triangles: Int[np.ndarray, "triangles 3"]) -> EdgeTable:
    """Sort the sides of the triangles by edge."""
    sides = directed_sides(triangles)
    ordered = np.sort(sides, axis=1)
    key = ordered[:, 0] * (int(triangles.max()) + 1) + ordered[:, 1]
    order = np.argsort(key, kind="stable")
    _, starts, counts = np.unique(key[order], return_index=True, return_counts=True)
    return EdgeTable(ordered[order[starts]], counts, starts, order, sides[:, 0] < sides[:, 1])


def open_sides(triangles: Int[np.ndarray, "triangles 3"]) -> Int[np.ndarray, "open 2"]:
    """Directed sides that no other triangle shares."""
    table = edge_table(triangles)
    return directed_sides(triangles)[table.order[table.starts[table.counts == 1]]]
