"""The sizing field on a background lattice."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from ._sizing import Sizing
from ._structured import lattice_cells
from ._surface import Surface

LARGEST_LATTICE = 48
"""Most lattice intervals along the longest side of the box."""

GROWTH = 0.5
"""By how much edges grow over the distance from where they are to be small [1]."""


def sizing_field(
    surface: Surface, sizing: Sizing
) -> tuple[Float[np.ndarray, "nodes 3"], Int[np.ndarray, "cells 4"], Float[np.ndarray, " nodes"]]:
    """Edge lengths [m] on a lattice of tetrahedra around the surface.

    The length is `skin` at the surface and grows linearly with the distance to `core` at `depth`;
    where the sizing is `fine` it is no longer than that says.
    """
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    shortest = min(sizing.depth, sizing.skin, *(one.edge for one in sizing.fine))
    step = max(shortest / 1.5, (high - low).max() / LARGEST_LATTICE)
    low, high = low - 2.0 * step, high + 2.0 * step
    counts = np.maximum(np.ceil((high - low) / step).astype(int), 2) + 1
    axes = [np.linspace(a, b, n) for a, b, n in zip(low, high, counts, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    # Distances are to a cloud of surface points about half a lattice step apart.
    cloud = KDTree(surface_cloud(surface, 0.5 * step))
    # Beyond the layer the distance does not matter and comes back infinite.
    distance, _ = cloud.query(nodes, distance_upper_bound=sizing.depth + step)
    # The lattice interpolates: within half a step of the surface it must already say `skin`.
    rise = np.clip((distance - 0.5 * step) / sizing.depth, 0.0, 1.0)
    x, y, z = (int(n) for n in counts)
    cells = lattice_cells((x, y, z)).astype(np.int32)
    edges = sizing.skin + (sizing.core - sizing.skin) * rise
    for one in sizing.fine:
        away, _ = KDTree(one.points).query(nodes)
        # All corners of a lattice cell with such a point in it must say so.
        beyond = np.maximum(away - max(step, one.edge), 0.0)
        edges = np.minimum(edges, one.edge + GROWTH * beyond)
    return nodes, cells, edges


def surface_cloud(surface: Surface, spacing: float) -> Float[np.ndarray, "points 3"]:
    """Points on the surface about `spacing` [m] apart, the vertices among them."""
    corners = surface.vertices[surface.triangles]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    parts = np.clip(np.ceil(longest / spacing).astype(int), 1, 64)
    points = [surface.vertices]
    for count in np.unique(parts[parts > 1]):
        i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
        keep = i + j <= count
        first, second = i[keep] / count, j[keep] / count
        weights = np.stack([1.0 - first - second, first, second], axis=1)
        points.append(np.einsum("qk,tki->tqi", weights, corners[parts == count]).reshape(-1, 3))
    every = np.concatenate(points)
    # Narrow triangles and common sides repeat points: keep one in each small brick.
    low = every.min(axis=0)
    bricks = np.floor((every - low) / (0.25 * spacing)).astype(np.int64)
    key = np.ravel_multi_index(tuple(bricks.T), tuple(bricks.max(axis=0) + 1))
    return every[np.unique(key, return_index=True)[1]]
