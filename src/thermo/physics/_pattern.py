"""The fixed sparsity of a mesh: its edges, and rows grouped by length for fast products.

A symmetric matrix on the mesh is stored twice. `edges` (one value for each pair of nodes that
share a cell) is what derivatives flow through. `rows` holds the same values row by row, padded to
equal lengths in a few groups, and is what products run over: gathers in groups of equal length,
written out one after the other, are faster than a scatter and than rows of any length.

Nodes inside come first, those of the surface last. A row of the surface is held in two blocks, its
edges on the surface apart, so that radiation changes one block and leaves the rest alone.
"""

from __future__ import annotations

from typing import Any, final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, Shaped

from thermo.physics._gather_sum import pick

RUN, SHORT_RUN = 16, 8
"""The most gathers [1] that are written out one after the other; longer rows loop over runs."""

FEW_NODES = 2000
"""Unknowns [1] below which compiling is most of the time, and short runs are as fast."""

GATHER_COST = 2000.0
"""Padded entries [1] that are worth one gather less to compile.

At 2000 a run takes as long as at 1000, at 4000 up to a third longer (`benchmarks/compiling.py`).
"""

Block = Shaped[Array | np.ndarray, "_loops _run _rows"]
"""Numbers of equally long rows, one column of the block after the other, in runs."""

Rows = tuple[Block, ...]
"""The values of a matrix, padded, block by block."""


@final
class Pattern(eqx.Module):
    """Connectivity of the unknowns; nodes inside, then those of the surface, by falling length.

    Arguments:

    - `first`, `second`: the two nodes of every edge, (edges,), first < second.
    - `columns`: for each block the node that an entry multiplies, padded with the row itself.
    - `source`: for each entry the edge that it holds; `edges` means zero.
    - `surface_edge`: the edges that both of whose nodes share a face, (surface_edges,).
    - `surface_source`: for each block of such edges their place in `surface_edge`.
    - `bounds`: first and last row of each block, and whether it holds edges of the surface;
      blocks of the same rows follow each other.
    - `inner`: number of nodes inside [1].
    """

    first: Int[Array | np.ndarray, " edges"]
    second: Int[Array | np.ndarray, " edges"]
    columns: tuple[Block, ...]
    source: tuple[Block, ...]
    surface_edge: Int[Array | np.ndarray, " surface_edges"]
    surface_source: tuple[Block, ...]
    bounds: tuple[tuple[int, int, bool], ...] = eqx.field(static=True)
    inner: int = eqx.field(static=True)


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


def _cut(length: Int[np.ndarray, " nodes"], longest: int) -> Int[np.ndarray, " cuts"]:
    """First rows of the groups: the least padding and the fewest gathers, over all groupings."""
    width, rows = np.unique(-length, return_counts=True)
    width, before = -width, np.concatenate([[0], np.cumsum(rows)])
    loops, gathers = _in_runs(width, longest)
    width = loops * gathers
    least, origin = np.zeros(len(width) + 1), np.zeros(len(width) + 1, int)
    for end in range(1, len(width) + 1):
        # A group is as wide as its first row.
        entries = width[:end] * (before[end] - before[:end])
        cost = least[:end] + entries + GATHER_COST * gathers[:end]
        origin[end] = int(np.argmin(cost))
        least[end] = cost[origin[end]]
    cuts = [len(width)]
    while cuts[-1] > 0:
        cuts.append(int(origin[cuts[-1]]))
    return before[cuts[::-1]]


def _block(
    low: int,
    high: int,
    entries: tuple[np.ndarray, np.ndarray, np.ndarray],
    padding: int,
    longest: int,
) -> tuple[Block, Block]:
    """Columns and sources of the rows from `low` to `high`, of entries sorted by row."""
    row, column, edge = entries
    length = np.bincount(row - low, minlength=high - low)
    width = int(length.max(initial=0))
    place = np.arange(len(row)) - (np.cumsum(length) - length)[row - low]
    (loops,), (run,) = _in_runs(np.array([width]), longest)
    numbers = np.tile(np.arange(low, high, dtype=np.int32), (loops * run, 1))
    numbers[place, row - low] = column
    held = np.full((loops * run, high - low), padding, np.int32)
    held[place, row - low] = edge
    return numbers.reshape(loops, run, -1), held.reshape(loops, run, -1)


def _in_runs(
    width: Int[np.ndarray, " groups"], longest: int
) -> tuple[Int[np.ndarray, " groups"], Int[np.ndarray, " groups"]]:
    """Into how many runs rows are cut, and how long these are [1]: evenly, with little padding."""
    loops = np.maximum(-(-width // longest), 1)
    return loops, -(-width // loops)


def make_pattern(
    pairs: Int[np.ndarray, "edges 2"],
    surface_edges: Int[np.ndarray, " some"],
    surface: Bool[np.ndarray, " nodes"],
) -> Pattern:
    """Group the rows of a matrix with the given edges.

    Arguments:

    - `pairs`: edges of the matrix graph, (edges, 2), sorted by first then second node.
    - `surface_edges`: the edges that lie in a face of the boundary.
    - `surface`: which nodes do; they come last.
    """
    edges, count = len(pairs), len(surface)
    inner = count - int(surface.sum())
    row = np.concatenate([pairs[:, 0], pairs[:, 1]])
    order = np.argsort(row, kind="stable")
    row, column = row[order], np.concatenate([pairs[:, 1], pairs[:, 0]])[order]
    edge = np.tile(np.arange(edges), 2)[order]
    length = np.bincount(row, minlength=count)
    outside = np.isin(edge, surface_edges)
    longest = RUN if count > FEW_NODES else SHORT_RUN
    cuts = [_cut(length[:inner], longest), inner + _cut(length[inner:], longest)]
    cuts = np.unique(np.concatenate(cuts))
    number = np.full(edges + 1, len(surface_edges))
    number[surface_edges] = np.arange(len(surface_edges))
    bounds, columns, sources, of_surface = [], [], [], []
    for low, high in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
        within = (row >= low) & (row < high)
        for flag in (False, True):
            part = within & (outside == flag)
            if not part.any() and (flag or high > inner):
                continue
            block, held = _block(low, high, (row[part], column[part], edge[part]), edges, longest)
            bounds.append((low, high, flag))
            columns.append(block)
            sources.append(held)
            if flag:
                of_surface.append(jax.tree.map(lambda a: number[a].astype(np.int32), held))
    return Pattern(
        first=pairs[:, 0],
        second=pairs[:, 1],
        columns=tuple(columns),
        source=tuple(sources),
        surface_edge=surface_edges.astype(np.int32),
        surface_source=tuple(of_surface),
        bounds=tuple(bounds),
        inner=inner,
    )


def of_surface(pattern: Pattern) -> Pattern:
    """The pattern of matrices on the nodes of the surface alone, numbered from zero."""
    inner, chosen = pattern.inner, pattern.surface_edge
    flags = [flag for *_, flag in pattern.bounds]
    columns = [block for block, flag in zip(pattern.columns, flags, strict=True) if flag]
    return Pattern(
        first=pattern.first[chosen] - inner,
        second=pattern.second[chosen] - inner,
        columns=jax.tree.map(lambda node: node - inner, tuple(columns)),
        source=pattern.surface_source,
        surface_edge=np.zeros(0, np.int32),
        surface_source=(),
        bounds=tuple((low - inner, high - inner, False) for low, high, f in pattern.bounds if f),
        inner=0,
    )


def _padded(values: Float[Array, "values *batch"]) -> Float[Array, "more *batch"]:
    return jnp.concatenate([values, jnp.zeros((1, *values.shape[1:]), values.dtype)])


def expand(pattern: Pattern, edges: Float[Array, " edges"]) -> Rows:
    """Padded rows of a matrix from its edge values (same unit)."""
    values = _padded(edges)
    return tuple(pick(values, place) for place in pattern.source)


def add_surface(pattern: Pattern, rows: Rows, extra: Float[Array, " surface_edges"]) -> Rows:
    """Padded rows with more on the edges of the surface (same unit)."""
    values = _padded(extra)
    changed, sources = [], iter(pattern.surface_source)
    for block, (_, _, flag) in zip(rows, pattern.bounds, strict=True):
        changed.append(block + pick(values, next(sources)) if flag else block)
    return tuple(changed)


def scale_rows(pattern: Pattern, rows: Rows, factor: Float[Array, " nodes"]) -> Rows:
    """Padded rows with each entry times the factors [1] of its row and of its column."""
    changed = []
    for (low, high, _), columns, block in zip(pattern.bounds, pattern.columns, rows, strict=True):
        changed.append(block * factor[low:high] * pick(factor, columns))
    return tuple(changed)


def row_product(
    pattern: Pattern,
    diagonal: Float[Array, " nodes"] | None,
    rows: Rows,
    vector: Float[Array, "nodes *batch"],
    *,
    differences: bool = False,
    lookup: Float[Array, "more *many"] | None = None,
) -> Float[Array, "nodes *wide"]:
    """Matrix times one vector, or times a batch of them laid out along the last axis.

    Arguments:

    - `rows`: the entries, or their places in `lookup` where that is given.
    - `differences`: whether an entry multiplies the difference to the row's own value.
    """
    ones = (1,) * (vector.ndim - 1)
    wide = jnp.broadcast_shapes(vector.shape[1:], () if lookup is None else lookup.shape[1:])
    groups: dict[int, Any] = {}
    for (low, high, _), columns, values in zip(pattern.bounds, pattern.columns, rows, strict=True):
        own = vector[low:high]

        def add(total: Array, run: tuple[Array, Array], own: Array = own) -> tuple[Array, None]:
            for held, column in zip(*run, strict=True):
                entry = held.reshape(-1, *ones) if lookup is None else pick(lookup, held)
                other = pick(vector, column)
                other = other - own if differences else other
                total = total + entry * other.astype(entry.dtype)
            return total, None

        total = groups.get(low)
        if total is None:
            total = jnp.zeros((high - low, *wide), vector.dtype)
            total = total if diagonal is None else diagonal[low:high].reshape(-1, *ones) * own
        runs = (jnp.asarray(values), jnp.asarray(columns))
        if len(values) == 1:
            groups[low] = add(total, (runs[0][0], runs[1][0]))[0]
        else:
            groups[low], _ = jax.lax.scan(add, total, runs)
    return jnp.concatenate(list(groups.values()))
