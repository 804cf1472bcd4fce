"""Where lines cross triangles, in double precision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jaxtyping import Bool, Float, Int

# A barycentric weight this far below 0 is rounding [1].
_ROUNDING: Final = 1e-12
# Neighbours that are tried in turn [1]: more than half of the triangles round any usual vertex.
_STEPS: Final = 8


@final
@dataclass(frozen=True)
class Crossing:
    """Where lines cross triangles.

    Arguments: `triangle` (lines,); `weights` (lines, 3) barycentric [1]; `along` the lines, in
    their unit; `crossed`, whether they cross at all, ahead of their start.
    """

    triangle: Int[np.ndarray, " lines"]
    weights: Float[np.ndarray, "lines 3"]
    along: Float[np.ndarray, " lines"]
    crossed: Bool[np.ndarray, " lines"]


def crossings(
    corners: Float[np.ndarray, "triangles 3 3"],
    neighbours: Int[np.ndarray, "triangles 3"],
    triangle: Int[np.ndarray, " lines"],
    starts: Float[np.ndarray, "lines 3"],
    lines: Float[np.ndarray, "lines 3"],
) -> Crossing:
    """Where lines cross the triangles proposed for them, or a neighbour of theirs.

    A line that passes beside its triangle is followed across the edge that it passes, some steps
    far. Weights that are below 0 by rounding are set to 0.

    Arguments: `corners`, and `starts` of the lines, in one unit; `triangle` -1 for none proposed;
    `neighbours` as `neighbours_across` gives them.
    """
    triangle = triangle.copy()
    weights, along = np.full((len(lines), 3), np.nan), np.full(len(lines), np.nan)
    crossed = np.zeros(len(lines), bool)
    open_lines = np.flatnonzero(triangle >= 0)
    for _ in range(_STEPS):
        here = triangle[open_lines]
        part, reach = _on_planes(corners[here], starts[open_lines], lines[open_lines])
        with np.errstate(invalid="ignore"):
            inside = (part >= -_ROUNDING).all(axis=1) & (reach > 0)
        done = open_lines[inside]
        clipped = np.maximum(part[inside], 0.0)
        weights[done] = clipped / clipped.sum(axis=1, keepdims=True)
        along[done], crossed[done] = reach[inside], True
        # NaN, of a triangle seen edge on, is the smallest here as well: any neighbour will do.
        onward = neighbours[here, np.argmin(part, axis=1)]
        further = ~inside & (onward >= 0)
        open_lines = open_lines[further]
        triangle[open_lines] = onward[further]
        if open_lines.size == 0:
            break
    return Crossing(triangle, weights, along, crossed)


def _on_planes(
    corners: np.ndarray, starts: np.ndarray, lines: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Barycentric weights of where lines meet the triangles' planes, and how far along."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    beside = np.cross(lines, second)
    apart = starts - corners[:, 0]
    turned = np.cross(apart, first)
    with np.errstate(divide="ignore", invalid="ignore"):
        volume = 1.0 / np.einsum("ij,ij->i", beside, first)
        u = np.einsum("ij,ij->i", apart, beside) * volume
        v = np.einsum("ij,ij->i", lines, turned) * volume
        along = np.einsum("ij,ij->i", second, turned) * volume
        # Of a triangle seen edge on both may be infinite.
        return np.stack([1.0 - u - v, u, v], axis=1), along


def neighbours_across(triangles: Int[np.ndarray, "triangles 3"]) -> Int[np.ndarray, "triangles 3"]:
    """The triangle across the edge opposite of each corner; -1 where there is none."""
    edges = np.sort(triangles[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2), axis=1)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    same = (edges[order[1:]] == edges[order[:-1]]).all(axis=1)
    across = np.full(len(edges), -1)
    left, right = order[:-1][same], order[1:][same]
    across[left], across[right] = right // 3, left // 3
    return across.reshape(-1, 3)
