"""Turning the triangles of a surface alike."""

from __future__ import annotations

import numpy as np
from jaxtyping import Int
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from thermo.errors import InputError

from ._edges import EdgeTable, edge_table


def consistent_winding(
    triangles: Int[np.ndarray, "triangles 3"], *, where: str
) -> tuple[Int[np.ndarray, "triangles 3"], Int[np.ndarray, " triangles"]]:
    """Triangles turned so that neighbours agree, and the body each belongs to.

    Within a body the turn of the majority is kept.

    Raises `InputError` where an edge has more than two triangles, or no turn fits (a one-sided
    surface).
    """
    table = edge_table(triangles)
    if (table.counts > 2).any():
        worst = int(np.argmax(table.counts))
        raise InputError(
            "an edge has more than two triangles",
            where=where,
            value=f"edge of vertices {table.edges[worst].tolist()} in {table.counts[worst]} "
            f"triangles, {(table.counts > 2).sum()} such edges",
            limit="2 triangles an edge",
            remedy="remove inner walls and separate touching parts",
        )
    left, right, agree = _neighbours(table)
    size = len(triangles)
    graph = csr_matrix((np.ones(len(left)), (left, right)), shape=(size, size))
    count, body = connected_components(graph, directed=False)
    if agree.all():
        return triangles, body
    sign = _signs(graph, left, right, agree, body, count)
    if (sign[left] * sign[right] != np.where(agree, 1, -1)).any():
        raise InputError(
            "the surface is one-sided",
            where=where,
            value="no consistent turn of its triangles",
            limit="a surface with an inside and an outside",
            remedy="repair it in a mesh editor",
        )
    return np.where((sign < 0)[:, None], triangles[:, [0, 2, 1]], triangles), body


def _neighbours(table: EdgeTable) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangles on both sides of each inner edge, and whether they turn alike."""
    start = table.starts[table.counts == 2]
    first, second = table.order[start], table.order[start + 1]
    # Alike means that the edge runs one way in one triangle and the other way in the other.
    return first // 3, second // 3, table.forward[first] != table.forward[second]


def _signs(
    graph: csr_matrix,
    left: np.ndarray,
    right: np.ndarray,
    agree: np.ndarray,
    body: np.ndarray,
    count: int,
) -> np.ndarray:
    """+1 for triangles to keep and -1 for those to turn, spread from neighbour to neighbour."""
    relation = {}
    for a, b, same in zip(left.tolist(), right.tolist(), agree.tolist(), strict=True):
        relation[a, b] = relation[b, a] = 1 if same else -1
    sign = np.zeros(len(body), int)
    for number in range(count):
        seed = int(np.argmax(body == number))
        order, parent = breadth_first_order(graph, seed, directed=False)
        sign[seed] = 1
        for item in order[1:].tolist():
            sign[item] = sign[parent[item]] * relation[int(parent[item]), item]
        members = body == number
        if sign[members].sum() < 0:
            sign[members] *= -1
    return sign
