"""The first triangle that a line of sight meets, exact to double precision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from jaxtyping import Bool, Float, Int

from thermo.errors import InputError

from ._ray_crossing import Crossing, crossings, neighbours_across
from ._surface import Surface

# Lines begin this far before the middle of the body, whose radius is one [1]: single precision then
# places them to 1e-7 of the body, however far the camera.
_BEFORE: Final = 1.01
# What a line is tried again at, to either side [1]: sixteen times what single precision resolves.
_ASIDE: Final = 1e-6
# A point is met at its own distance, to this share of the body's radius [1].
_OWN: Final = 1e-6


@final
@dataclass(frozen=True)
class Caster:
    """A surface that rays can be cast at, moved to the origin and scaled to radius one.

    Arguments:

    - `scene`: Embree's search tree. Its own answers are single precision, and now and then a ray
      slips through an edge.
    - `corners`: of the triangles, (triangles, 3, 3) [1]. `neighbours`: across each edge, or -1.
    - `middle`, `radius`: what the surface was moved by and divided by [m].
    """

    scene: Any
    corners: Float[np.ndarray, "triangles 3 3"]
    neighbours: Int[np.ndarray, "triangles 3"]
    middle: Float[np.ndarray, "3"]
    radius: float


@final
@dataclass(frozen=True)
class RayHits:
    """What rays meet first.

    Arguments: `triangle` (rays,), -1 for none; `weights` (rays, 3) barycentric, at least 0, of sum
    1, NaN for none; `distance` along the rays [m], infinite for none.
    """

    triangle: Int[np.ndarray, " rays"]
    weights: Float[np.ndarray, "rays 3"]
    distance: Float[np.ndarray, " rays"]


def caster_of(surface: Surface) -> Caster:
    """Prepare a surface for `first_hits`.

    Raises `InputError` where it has no triangle, or vertices [m] that are not finite.
    """
    if len(surface.triangles) == 0 or not np.isfinite(surface.vertices).all():
        raise InputError(
            "this surface cannot be looked at", where="surface",
            value=f"{len(surface.triangles)} triangles, {len(surface.vertices)} vertices",
            limit="at least one triangle, finite vertices [m]",
            remedy="read it by `thermo.mesh.read_surface`, which checks it",
        )  # fmt: skip
    used = surface.vertices[np.unique(surface.triangles)]
    middle = (used.min(axis=0) + used.max(axis=0)) / 2
    radius = float(np.linalg.norm(used - middle, axis=1).max()) or 1.0
    unit = (surface.vertices - middle) / radius
    # Without `robust`, a ray in a hundred that goes through an edge meets nothing there.
    scene = EmbreeScene(robust=True)
    TriangleMesh(
        scene=scene, vertices=unit.astype(np.float32), indices=surface.triangles.astype(np.int32)
    )
    neighbours = neighbours_across(surface.triangles)
    return Caster(scene, unit[surface.triangles], neighbours, middle, radius)


def first_hits(
    caster: Caster, place: Float[np.ndarray, "*rays 3"], directions: Float[np.ndarray, "rays 3"]
) -> RayHits:
    """The first triangle that rays meet, which begin at one place, or each at its own [m].

    Embree proposes triangles, for the ray itself and for two that are shifted to either side by a
    millionth of the body's radius; which of them the ray crosses, and where, is computed in double
    precision, going on to a neighbour where it passes beside. What is nearest is met.

    Arguments: `directions` of length one [1]; rays with NaN meet nothing.

    Source: Moeller and Trumbore, J. Graphics Tools 2 (1997) 21; Wald et al., ACM Trans. Graphics 33
    (2014) 143 (Embree).
    """
    count = len(directions)
    triangle = np.full(count, -1)
    weights, distance = np.full((count, 3), np.nan), np.full(count, np.inf)
    eye = np.broadcast_to((place - caster.middle) / caster.radius, directions.shape)
    ahead = -(directions * eye).sum(axis=1)
    beside = np.linalg.norm(eye + ahead[:, None] * directions, axis=1)
    tried = np.flatnonzero((beside < _BEFORE) & (ahead > -_BEFORE))
    lines = directions[tried]
    skipped = np.maximum(ahead[tried] - _BEFORE, 0.0)
    starts = eye[tried] + skipped[:, None] * lines
    for shift in (0.0, _ASIDE, -_ASIDE):
        found = _crossed(caster, starts, lines, shift)
        reach = skipped + found.along
        better = found.crossed & (reach * caster.radius < distance[tried])
        rays = tried[better]
        triangle[rays], weights[rays] = found.triangle[better], found.weights[better]
        distance[rays] = reach[better] * caster.radius
    return RayHits(triangle, weights, distance)


def unhindered(
    caster: Caster, place: Float[np.ndarray, "3"], points: Float[np.ndarray, "points 3"]
) -> Bool[np.ndarray, " points"]:
    """Whether the lines from one place [m] to points on the surface [m] meet nothing before them.

    Points within 1e-6 of the body's radius behind a silhouette may go either way. A point at the
    place itself counts as met.
    """
    away = points - place
    length = np.linalg.norm(away, axis=1)
    with np.errstate(invalid="ignore"):
        met = first_hits(caster, place, away / length[:, None])
    return met.distance >= length - _OWN * caster.radius


def _crossed(caster: Caster, starts: np.ndarray, lines: np.ndarray, shift: float) -> Crossing:
    """Where the lines cross the triangles that Embree finds for them, shifted sideways."""
    if len(lines) == 0:
        return crossings(caster.corners, caster.neighbours, np.zeros(0, int), starts, lines)
    # At right angles to the line, and along no axis, as edges of made bodies often are.
    side = np.cross(lines, [0.267, 0.535, 0.802])
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-3)
    met = caster.scene.run((starts + shift * side).astype(np.float32), lines.astype(np.float32))
    return crossings(caster.corners, caster.neighbours, np.asarray(met, int), starts, lines)
