"""Edges at which a surface turns inward, as at a rib's foot."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Float

from ._edges import edge_table
from ._geometry import triangle_normals
from ._surface import Surface

TURN: Final = np.pi / 4
"""Angle by which a surface turns at an edge that is more than the side of a curved part [1]."""


def inner_edges(surface: Surface, spacing: float) -> Float[np.ndarray, "points 3"]:
    """Points [m] along edges at which a surface turns inward, no farther apart than `spacing` [m].

    Heat crowds where it passes such an edge: its flux grows as r^(pi / angle - 1) towards it, with
    the angle of the body there, above pi. What cells make wrong falls more slowly there with their
    size than elsewhere, unless they are small about the edge.

    Arguments: `surface`: its triangles turned outward [m].

    Source: Strang and Fix, An Analysis of the Finite Element Method (1973), chapter 8.
    """
    table = edge_table(surface.triangles)
    twice = table.counts == 2
    start = table.starts[twice]
    one, other = table.order[start] // 3, table.order[start + 1] // 3
    normals, _ = triangle_normals(surface.vertices, surface.triangles)
    ends = surface.vertices[table.edges[twice]]
    across = surface.vertices[surface.triangles[other]].mean(axis=1) - ends[:, 0]
    inward = np.einsum("ei,ei->e", across, normals[one]) > 0
    turned = np.einsum("ei,ei->e", normals[one], normals[other]) <= np.cos(TURN)
    low, high = ends[inward & turned].swapaxes(0, 1)
    count = np.ceil(np.linalg.norm(high - low, axis=1) / spacing).astype(int)
    number = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    share = ((number + 0.5) / np.repeat(count, count))[:, None]
    return (1 - share) * np.repeat(low, count, axis=0) + share * np.repeat(high, count, axis=0)
