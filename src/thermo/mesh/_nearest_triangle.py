"""The nearest of many triangles."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from ._geometry import triangle_normals
from ._nearest import closest_on_triangles

LARGEST_BATCH: Final = 400000
"""Most pairs of point and triangle that are tried at once, to bound the memory."""

LIKE_SIZE: Final = 4.0
"""Pieces whose radii differ by less than this [1] are searched together."""

MOST_CUTS: Final = 4
"""Most pieces over those that are wanted [1]."""


def nearest_triangle(
    corners: Float[np.ndarray, "triangles 3 3"], points: Float[np.ndarray, "samples 3"]
) -> tuple[
    Int[np.ndarray, " samples"], Float[np.ndarray, "samples 3"], Float[np.ndarray, " samples"]
]:
    """The nearest triangle of each point, its barycentric coordinates there and the distance [m].

    Triangles are searched by pieces of them, in classes of like size, so that long ones and a few
    large ones cost little; the answer is exact.
    """
    owner, pieces = _cut(corners, len(corners) + len(points) // 8)
    centres, radii = pieces.mean(axis=1), _radii(pieces)
    widest = max(float(radii.max()), np.finfo(float).tiny)
    share = np.maximum(radii / widest, LIKE_SIZE**-10)
    classes = np.floor(np.log(share) / np.log(LIKE_SIZE))
    loose = np.arange(3 * len(corners)).reshape(-1, 3)
    normals, _ = triangle_normals(corners.reshape(-1, 3), loose)
    count = len(points)
    found = (np.zeros(count, np.int64), np.zeros((count, 3)), np.full(count, np.inf))
    for size in np.unique(classes):
        members = np.flatnonzero(classes == size)
        tree, radius = KDTree(centres[members]), float(radii[members].max())
        _search(corners, normals, owner[members], tree, radius, points, *found)
    return found


def _radii(corners: Float[np.ndarray, "pieces 3 3"]) -> Float[np.ndarray, " pieces"]:
    """How far the corners are from the centre at the most [m]."""
    apart = corners - corners.mean(axis=1, keepdims=True)
    return np.sqrt((apart**2).sum(axis=2).max(axis=1))


def _cut(
    corners: Float[np.ndarray, "triangles 3 3"], wanted: int
) -> tuple[Int[np.ndarray, " pieces"], Float[np.ndarray, "pieces 3 3"]]:
    """Triangles cut in halves across their longest edges, and whose each piece is [1].

    Pieces become as small as `wanted` ones with four times that area, unless those are too many.
    """
    owner, pieces = np.arange(len(corners)), corners
    loose = np.arange(3 * len(corners)).reshape(-1, 3)
    _, areas = triangle_normals(corners.reshape(-1, 3), loose)
    limit = 2.0 * float(np.sqrt(areas.sum() / wanted))
    while True:
        large = _radii(pieces) > limit
        if not large.any() or len(pieces) + large.sum() > MOST_CUTS * wanted:
            return owner, pieces
        halves = _halves(pieces[large])
        owner = np.concatenate([owner[~large], owner[large], owner[large]])
        pieces = np.concatenate([pieces[~large], *halves])


def _halves(pieces: Float[np.ndarray, "pieces 3 3"]) -> tuple[np.ndarray, np.ndarray]:
    """Both halves of triangles that are cut across their longest edges [m]."""
    edges = np.roll(pieces, -1, axis=1) - pieces
    longest = (edges**2).sum(axis=2).argmax(axis=1)
    line = np.arange(len(pieces))
    one, two, apex = (pieces[line, (longest + by) % 3] for by in range(3))
    middle = 0.5 * (one + two)
    return np.stack([one, middle, apex], axis=1), np.stack([middle, two, apex], axis=1)


def _search(
    corners: np.ndarray,
    normals: np.ndarray,
    owner: np.ndarray,
    tree: KDTree,
    radius: float,
    points: np.ndarray,
    face: np.ndarray,
    barycentric: np.ndarray,
    distance: np.ndarray,
) -> None:
    """Improve the three result arrays in place with the pieces of one size class.

    `owner`: whose each piece of `tree` is [1]; `radius`: of the largest piece [m].
    """
    open_points, count = np.arange(len(points)), min(8, len(owner))
    while open_points.size:
        reach, hits = tree.query(points[open_points], k=count)
        reach, hits = reach.reshape(-1, count), hits.reshape(-1, count)
        parts = len(open_points) * count // LARGEST_BATCH + 1
        for rows in np.array_split(np.arange(len(open_points)), parts):
            chosen = open_points[rows]
            tries, near = owner[hits[rows]], reach[rows] - radius
            # The first one brings most points so near that few of the others can be nearer.
            for some in (slice(0, 1), slice(1, None)):
                _try(corners, normals, chosen, tries[:, some], near[:, some], points,
                     face, barycentric, distance)  # fmt: skip
        # Every piece not tried yet has its centre beyond the last one tried.
        unsure = reach[:, -1] - radius < distance[open_points]
        open_points = open_points[unsure] if count < len(owner) else open_points[:0]
        count = min(4 * count, len(owner))


def _try(
    corners: np.ndarray,
    normals: np.ndarray,
    chosen: np.ndarray,
    tries: np.ndarray,
    near: np.ndarray,
    points: np.ndarray,
    face: np.ndarray,
    barycentric: np.ndarray,
    distance: np.ndarray,
) -> None:
    """Improve the results of the `chosen` points with the triangles of which they try some.

    Only those that can be nearer: whose piece is no farther than `near` [m], and not the plane.
    """
    if not tries.shape[1]:
        return
    least = distance[chosen, None]
    row, column = np.nonzero((near < least) & (tries != face[chosen, None]) | np.isinf(least))
    at, tried = chosen[row], tries[row, column]
    plane = np.abs(np.einsum("si,si->s", points[at] - corners[tried, 0], normals[tried]))
    kept = plane < distance[at]
    row, column, at, tried = row[kept], column[kept], at[kept], tried[kept]
    weight, gap = closest_on_triangles(corners[tried], points[at])
    gaps, at_gap = np.full(tries.shape, np.inf), np.zeros(tries.shape, np.int64)
    gaps[row, column], at_gap[row, column] = gap, np.arange(len(row))
    best, line = np.argmin(gaps, axis=1), np.arange(len(chosen))
    better = gaps[line, best] < distance[chosen]
    to, found = chosen[better], at_gap[line, best][better]
    distance[to], barycentric[to], face[to] = gap[found], weight[found], tried[found]
