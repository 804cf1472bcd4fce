"""The fixed sparsity of a mesh: its edges, and rows grouped by length for fast products.

A symmetric matrix on the mesh is stored twice. `diagonal` and `edges` (one value for each pair of
nodes that share a cell) are what derivatives flow through. `rows` holds the same values row by
row, padded to equal lengths in a few groups, and is what the linear solver multiplies with:
gathers in short runs are faster than a scatter, and few of them compile soon.
"""

from __future__ import annotations

from typing import Any, final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, Shaped

RUN = 8
"""Gathers [1] that are written out one after the other; the rest of a group loops over runs."""

GATHER_COST = 1000.0
"""Padded entries [1] that are worth one gather less to compile."""

Runs = tuple[
    Shaped[Array | np.ndarray, "_loops run _rows"], Shaped[Array | np.ndarray, "_rest _rows"]
]


@final
class Pattern(eqx.Module):
    """Connectivity of the unknowns; nodes must be ordered by falling row length.

    Arguments:

    - `first`, `second`: the two nodes of every edge, (edges,), first < second.
    - `columns`: for each group the node numbers in runs, (loops, RUN, rows), and what is left
      over, (rest, rows); padded with the row itself.
    - `source`: for each padded entry the edge that it holds, (entries,); `edges` means zero.
    - `hit`, `hit_edge`: the entries that hold an edge of the surface, and that edge, so that a
      change on the surface rewrites only these.
    - `bounds`: first and last row of each group.
    """

    first: Int[Array | np.ndarray, " edges"]
    second: Int[Array | np.ndarray, " edges"]
    columns: tuple[Runs, ...]
    source: Int[Array | np.ndarray, " entries"]
    hit: Int[Array | np.ndarray, " hits"]
    hit_edge: Int[Array | np.ndarray, " hits"]
    bounds: tuple[tuple[int, int], ...] = eqx.field(static=True)


def row_lengths(pairs: Int[np.ndarray, "edges 2"], count: int) -> Int[np.ndarray, " nodes"]:
    """Number of neighbours [1] of each node."""
    return np.bincount(pairs.ravel(), minlength=count)


def cell_pairs(
    cells: Int[np.ndarray, "cells corners"], count: int
) -> tuple[Int[np.ndarray, "edges 2"], Int[np.ndarray, "cells pairs"]]:
    """Edges of the matrix graph, and for each cell the edge of each of its node pairs."""
    a, b = np.triu_indices(cells.shape[1], 1)
    low = np.minimum(cells[:, a], cells[:, b]).astype(np.int64)
    high = np.maximum(cells[:, a], cells[:, b]).astype(np.int64)
    key, inverse = np.unique((low * count + high).ravel(), return_inverse=True)
    pairs = np.stack([key // count, key % count], 1).astype(np.int32)
    return pairs, inverse.reshape(low.shape).astype(np.int32)


def find_pairs(
    pairs: Int[np.ndarray, "edges 2"], groups: Int[np.ndarray, "faces corners"], count: int
) -> Int[np.ndarray, "faces pairs"]:
    """The edge of each node pair of each face."""
    a, b = np.triu_indices(groups.shape[1], 1)
    low = np.minimum(groups[:, a], groups[:, b]).astype(np.int64)
    high = np.maximum(groups[:, a], groups[:, b]).astype(np.int64)
    key = pairs[:, 0].astype(np.int64) * count + pairs[:, 1]
    return np.searchsorted(key, low * count + high).astype(np.int32)


def _cut(length: Int[np.ndarray, " nodes"]) -> Int[np.ndarray, " cuts"]:
    """First rows of the groups: the least padding and the fewest gathers, over all groupings."""
    width, rows = np.unique(-length, return_counts=True)
    width, before = -width, np.concatenate([[0], np.cumsum(rows)])
    gathers = np.where(width < 2 * RUN, width, RUN + width % RUN)
    least, origin = np.zeros(len(width) + 1), np.zeros(len(width) + 1, int)
    for end in range(1, len(width) + 1):
        # A group is as wide as its first row.
        cost = (
            least[:end] + width[:end] * (before[end] - before[:end]) + GATHER_COST * gathers[:end]
        )
        origin[end] = int(np.argmin(cost))
        least[end] = cost[origin[end]]
    cuts = [len(width)]
    while cuts[-1] > 0:
        cuts.append(int(origin[cuts[-1]]))
    return before[cuts[::-1]]


def make_pattern(
    pairs: Int[np.ndarray, "edges 2"], surface_edges: Int[np.ndarray, " some"], count: int
) -> Pattern:
    """Group the rows of a matrix with the given edges.

    Arguments:

    - `pairs`: edges of the matrix graph, (edges, 2), sorted by first then second node.
    - `surface_edges`: the edges that lie on the boundary.
    - `count`: number of nodes [1].
    """
    edges = len(pairs)
    row = np.concatenate([pairs[:, 0], pairs[:, 1]])
    column = np.concatenate([pairs[:, 1], pairs[:, 0]])
    edge = np.tile(np.arange(edges), 2)
    order = np.argsort(row, kind="stable")
    row, column, edge = row[order], column[order], edge[order]
    length = np.bincount(row, minlength=count)
    start = np.concatenate([[0], np.cumsum(length)])
    cuts = _cut(length)
    bounds, columns, sources = [], [], []
    for low, high in zip(cuts[:-1], cuts[1:], strict=True):
        width = int(length[low:high].max())
        piece = slice(int(start[low]), int(start[high]))
        place = np.arange(int(start[low]), int(start[high])) - start[row[piece]]
        numbers = np.tile(np.arange(low, high), (width, 1))
        numbers[place, row[piece] - low] = column[piece]
        held = np.full((width, high - low), edges)
        held[place, row[piece] - low] = edge[piece]
        bounds.append((int(low), int(high)))
        columns.append(_cut_runs(numbers.astype(np.int32)))
        sources.append(held.ravel())
    source = np.concatenate(sources).astype(np.int32)
    hit = np.flatnonzero(np.isin(source, surface_edges)).astype(np.int32)
    return Pattern(
        first=pairs[:, 0],
        second=pairs[:, 1],
        columns=tuple(columns),
        source=source,
        hit=hit,
        hit_edge=source[hit],
        bounds=tuple(bounds),
    )


def expand(pattern: Pattern, edges: Float[Array, " edges"]) -> Float[Array, " entries"]:
    """Padded rows of a matrix from its edge values (same unit)."""
    return jnp.concatenate([edges, jnp.zeros(1, edges.dtype)])[pattern.source]


def rewrite_surface(
    pattern: Pattern, rows: Float[Array, " entries"], edges: Float[Array, " edges"]
) -> Float[Array, " entries"]:
    """Padded rows with the surface's entries taken anew from the edge values (same unit)."""
    return rows.at[pattern.hit].set(edges[pattern.hit_edge], unique_indices=True)


def _cut_runs(
    rows: Shaped[np.ndarray, "width rows"] | Shaped[Array, "width rows"],
) -> tuple[Any, Any]:
    """The runs of a group, (loops, RUN, rows), and what is left over, (rest, rows)."""
    width, size = rows.shape
    loops = width // RUN if width >= 2 * RUN else 0
    return rows[: loops * RUN].reshape(loops, RUN, size), rows[loops * RUN :]


def split_rows(pattern: Pattern, rows: Shaped[Array, " entries"]) -> tuple[Runs, ...]:
    """The padded rows of each group, cut into runs: done once, before a solver's loop."""
    pieces, offset = [], 0
    for (low, high), (runs, rest) in zip(pattern.bounds, pattern.columns, strict=True):
        size = (runs.shape[0] * RUN + rest.shape[0]) * (high - low)
        pieces.append(_cut_runs(rows[offset : offset + size].reshape(-1, high - low)))
        offset += size
    return tuple(pieces)


def _group_product(
    values: Runs, columns: Runs, vector: Float[Array, "nodes *batch"], total: Array
) -> Float[Array, "rows *batch"]:
    """Add one group's gathers to `total`: its runs in a loop, then what is left over."""
    shape = (-1, *(1,) * (vector.ndim - 1))

    def add(total: Array, piece: tuple[Array, Array]) -> tuple[Array, None]:
        for weight, column in zip(*piece, strict=True):
            total = total + weight.reshape(shape) * vector[column]
        return total, None

    runs, rest = zip(
        jax.tree.map(jnp.asarray, values), jax.tree.map(jnp.asarray, columns), strict=True
    )
    if len(runs[0]):
        total, _ = jax.lax.scan(add, total, runs)
    return add(total, rest)[0]


def row_product(
    pattern: Pattern,
    diagonal: Float[Array, " nodes"],
    pieces: tuple[Runs, ...],
    vector: Float[Array, "nodes *batch"],
) -> Float[Array, "nodes *batch"]:
    """Matrix times one vector, or times a batch of them laid out along the last axis."""
    ones = (1,) * (vector.ndim - 1)
    groups = []
    for (low, high), columns, values in zip(pattern.bounds, pattern.columns, pieces, strict=True):
        total = diagonal[low:high].reshape(-1, *ones) * vector[low:high]
        groups.append(_group_product(values, columns, vector, total))
    return jnp.concatenate(groups)
