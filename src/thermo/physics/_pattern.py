"""The fixed sparsity of a mesh: its edges, and rows grouped by length for fast products.

A symmetric matrix on the mesh is stored twice. `diagonal` and `edges` (one value for each pair of
nodes that share a cell) are what derivatives flow through: a product is a gather and a scatter,
and so is its transpose. `rows` holds the same values row by row, padded to equal lengths in a few
groups, and is what the linear solver multiplies with: unrolled gathers reach the speed of a
compiled sparse product.
"""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

GROUPS = 16
UNROLL = 8


@final
class Pattern(eqx.Module):
    """Connectivity of the unknowns; nodes must be ordered by falling row length.

    Arguments:

    - `first`, `second`: the two nodes of every edge, (edges,), first < second.
    - `columns`: for each group the node numbers, (width, rows), padded with the row itself.
    - `source`: for each padded entry the edge that it holds, (entries,); `edges` means zero.
    - `hit`, `hit_edge`: the entries that hold an edge of the surface, and that edge, so that a
      change on the surface rewrites only these.
    - `bounds`: first and last row of each group.
    """

    first: Int[Array | np.ndarray, " edges"]
    second: Int[Array | np.ndarray, " edges"]
    columns: tuple[Int[Array | np.ndarray, "_width _rows"], ...]
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
    cuts = np.unique(np.linspace(0, count, GROUPS + 1).astype(int))
    bounds, columns, sources = [], [], []
    for low, high in zip(cuts[:-1], cuts[1:], strict=True):
        width = int(length[low:high].max())
        piece = slice(start[low], start[high])
        place = np.arange(piece.start, piece.stop) - start[row[piece]]
        numbers = np.tile(np.arange(low, high), (width, 1))
        numbers[place, row[piece] - low] = column[piece]
        held = np.full((width, high - low), edges)
        held[place, row[piece] - low] = edge[piece]
        bounds.append((int(low), int(high)))
        columns.append(numbers.astype(np.int32))
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


def _group_product(
    values: Float[Array, "width rows *ones"],
    columns: Int[Array | np.ndarray, "width rows"],
    vector: Float[Array, "nodes *batch"],
    total: Float[Array, "rows *batch"],
) -> Float[Array, "rows *batch"]:
    """Add one group's gathers to `total`: unrolled, and wide groups in a loop of short runs."""
    width = columns.shape[0]
    loops = width // UNROLL if width > 4 * UNROLL else 0
    if loops:
        head = loops * UNROLL
        pieces = (
            values[:head].reshape(loops, UNROLL, *values.shape[1:]),
            jnp.asarray(columns[:head]).reshape(loops, UNROLL, -1),
        )

        def add(total: Array, piece: tuple[Array, Array]) -> tuple[Array, None]:
            for place in range(UNROLL):
                total = total + piece[0][place] * vector[piece[1][place]]
            return total, None

        total, _ = jax.lax.scan(add, total, pieces)
    for place in range(loops * UNROLL, width):
        total = total + values[place] * vector[columns[place]]
    return total


def row_product(
    pattern: Pattern,
    diagonal: Float[Array, " nodes"],
    rows: Float[Array, " entries"],
    vector: Float[Array, "nodes *batch"],
) -> Float[Array, "nodes *batch"]:
    """Matrix times one vector, or times a batch of them laid out along the last axis."""
    batch = (1,) * (vector.ndim - 1)
    pieces, offset = [], 0
    for (low, high), columns in zip(pattern.bounds, pattern.columns, strict=True):
        width, size = columns.shape
        values = rows[offset : offset + width * size].reshape(width, size, *batch)
        total = diagonal[low:high].reshape(-1, *batch) * vector[low:high]
        pieces.append(_group_product(values, columns, vector, total))
        offset += width * size
    return jnp.concatenate(pieces)


def edge_product(
    pattern: Pattern,
    diagonal: Float[Array, " nodes"],
    edges: Float[Array, " edges"],
    vector: Float[Array, " nodes"],
) -> Float[Array, " nodes"]:
    """Matrix times vector through the edges: as cheap to transpose as to apply."""
    ends = jnp.concatenate([pattern.first, pattern.second])
    terms = jnp.concatenate([edges * vector[pattern.second], edges * vector[pattern.first]])
    return (diagonal * vector).at[ends].add(terms)


def difference_product(
    pattern: Pattern, edges: Float[Array, " edges"], vector: Float[Array, " nodes"]
) -> Float[Array, " nodes"]:
    """Product with a matrix whose rows sum to zero, from differences only.

    Constants give exactly zero, which keeps a body at rest at rest to the last bit.
    """
    flow = edges * (vector[pattern.second] - vector[pattern.first])
    ends = jnp.concatenate([pattern.first, pattern.second])
    return jnp.zeros_like(vector).at[ends].add(jnp.concatenate([flow, -flow]))
