"""How many nodes a mesh will have, estimated before it is made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from thermo._remembered import remembered

from ._edges import edge_table
from ._geometry import triangle_normals
from ._sizing import Sizing
from ._sizing_field import surface_cloud
from ._surface import Surface
from ._thickness import inward_rays

INSIDE: Final = 13.0
"""TET10 nodes in one edge length cubed, deep inside; counted on meshes made by pytetwild."""

SURFACE: Final = 7.5
"""TET10 nodes on and next to one edge length squared of surface."""

SLACK: Final = 0.45
"""Longest edge inside a thin part, over its thickness; no cell is longer than its place."""

STEPS: Final = 16
"""Samples along each ray through the body."""

CREASE: Final = np.pi / 5.0
"""Angle between neighbouring triangles from which an edge is a crease and not a curved side."""


@final
@dataclass(frozen=True)
class Shape:
    """What the node count needs to know of a surface.

    Arguments:

    - `volume`: [m3]; `diagonal`: of the box [m].
    - `areas`: (triangles,) [m2].
    - `curvature`: (triangles,) about the larger principal curvature [1/m].
    - `through`: (rays,) thicknesses [m].
    - `distance`: (rays, samples) distance from the surface at even steps along the rays [m].
    """

    volume: float
    diagonal: float
    areas: Float[np.ndarray, " triangles"]
    curvature: Float[np.ndarray, " triangles"]
    through: Float[np.ndarray, " rays"]
    distance: Float[np.ndarray, "rays samples"]


def shape_of(surface: Surface) -> Shape:
    """Measure a closed surface; its thickness is the diagonal [m] where no ray comes out.

    What was measured last is kept: a fit's meshes are all sized by one surface.
    """
    return _measured(surface.vertices, surface.triangles)


@remembered(2)
def _measured(
    vertices: Float[np.ndarray, "vertices 3"], triangles: Int[np.ndarray, "triangles 3"]
) -> Shape:
    surface = Surface(vertices, triangles)
    normals, areas = triangle_normals(surface.vertices, surface.triangles)
    rays = inward_rays(surface)
    through = rays.lengths
    if through.size:
        along = through[:, None] * (np.arange(STEPS) + 0.5) / STEPS
        points = rays.starts[:, None] + along[..., None] * rays.directions[:, None]
        cloud = KDTree(surface_cloud(surface, surface.diagonal() / 60.0))
        # Approximate: near the middle of a ball all of the surface is equally far.
        distance = cloud.query(points, eps=0.1)[0]
    else:
        through, distance = np.array([surface.diagonal()]), np.zeros((1, STEPS))
    return Shape(
        abs(surface.volume()),
        surface.diagonal(),
        areas,
        _curvature(surface, normals, areas),
        through,
        distance,
    )


def _curvature(surface: Surface, normals: np.ndarray, areas: np.ndarray) -> np.ndarray:
    """Curvature of each triangle from the bends of its sides; creases do not count.

    The integral of the mean curvature over an edge is its length times half its angle; half of
    it belongs to each side. The larger principal curvature is one to two times the mean one.
    """
    table = edge_table(surface.triangles)
    inner = table.counts == 2
    start = table.starts[inner]
    left, right = table.order[start] // 3, table.order[start + 1] // 3
    ends = surface.vertices[table.edges[inner]]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    angle = np.arccos(np.clip((normals[left] * normals[right]).sum(axis=1), -1.0, 1.0))
    share = 0.25 * length * np.where(angle < CREASE, angle, 0.0)
    total = np.bincount(left, share, len(areas)) + np.bincount(right, share, len(areas))
    return 1.5 * total / np.maximum(areas, np.finfo(float).tiny)


def nodes_for(shape: Shape, sizing: Sizing, tolerance: float) -> float:
    """Estimated TET10 nodes: 13 per edge cubed inside and 7.5 per edge squared of the surface.

    A surface of curvature k that may deviate by `tolerance` [m] needs edges of
    sqrt(6 tolerance / k) even where `skin` is longer, but is not made finer than it is given.
    """
    rise = np.clip(shape.distance / sizing.depth, 0.0, 1.0)
    edge = sizing.skin + (sizing.core - sizing.skin) * rise
    room = SLACK * 2.0 * shape.distance.max(axis=1, keepdims=True)
    edge = np.minimum(edge, np.maximum(room, sizing.skin))
    # Every ray stands for a piece of the body in proportion to its length.
    dense = np.average((edge**-3.0).mean(axis=1), weights=shape.through)
    given = np.sqrt(3.0) / 4.0 / np.maximum(shape.areas, np.finfo(float).tiny)
    bent = np.minimum(shape.curvature / (6.0 * tolerance), given)
    squares = (shape.areas * np.maximum(bent, sizing.skin**-2.0)).sum()
    return float(INSIDE * shape.volume * dense + SURFACE * squares)


def expected_nodes(surface: Surface, sizing: Sizing) -> float:
    """Estimated number of TET10 nodes of the mesh that `tetrahedralise` will make.

    Arguments: `surface` closed [m], `sizing` the wanted edge lengths [m]. Found within a third
    on most bodies of 40 to 90 mm.
    """
    return nodes_for(shape_of(surface), sizing, sizing.envelope(surface))
