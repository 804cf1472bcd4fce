"""Whether the boxes, lamps and samples of a scene have to do with its surface at all."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Float
from trimesh.intersections import slice_faces_plane

from thermo.errors import InputError
from thermo.inverse._span_of_samples import check_span
from thermo.mesh import Surface, nearest_triangle
from thermo.observe import Box, Heater, Run, Scene

# An axis that passes farther away, in diagonals of the object [1], was not meant.
_PASSES: Final = 10.0

# Of its radii [1], beside which a spot has no light to speak of: 4e-6 of that in its middle. All of
# the lamp's power would go where the object comes nearest.
_BESIDE: Final = 5.0

# What lies on a box's sides counts as inside despite rounding, in diagonals of the object [1].
SLACK: Final = 1e-6


def check_places(scene: Scene, surface: Surface) -> None:
    """Refuse boxes that hold no part of the surface, lamps far from it, a smaller body's samples.

    All runs are looked at, whichever are asked for, and before anything is meshed.

    Arguments:

    - `scene`: with the boxes of what is prescribed, insulated or under other air, and the lamps.
    - `surface`: the object's, in the axes of these [m].

    Raises `InputError`, which names the file, the run and the key.
    """
    file = scene.folder / "scene.json"
    for run in scene.runs.values():
        where = f"{file}: runs.{run.name}" if file.exists() else f"runs.{run.name}"
        for key, box in _boxes(run):
            if not _meets(box, surface):
                what = "no part of the surface lies in this box"
                raise misses(what, f"{where}.{key}", box, surface.vertices)
        if run.heater is not None:
            _check_lamp(run.heater, surface, f"{where}.heater")
        check_span(run.recording, surface, f"{where}.recording")


def _boxes(run: Run) -> list[tuple[str, Box]]:
    """The boxes of a run, each with its key in the scene's file."""
    return [
        *((f"prescribed[{n}].box", one.box()) for n, one in enumerate(run.prescribed)),
        *((f"insulated[{n}]", one) for n, one in enumerate(run.insulated)),
        *((f"air[{n}].box", one.box) for n, one in enumerate(run.air)),
    ]


def _meets(box: Box, surface: Surface) -> bool:
    slack = SLACK * surface.diagonal()
    corners = surface.vertices[surface.triangles]
    near = (corners.max(1) >= box.low - slack) & (corners.min(1) <= box.high + slack)
    vertices, triangles = surface.vertices, surface.triangles[near.all(1)]
    for axis in range(3):
        for sign, side in ((1.0, box.low[axis] - slack), (-1.0, box.high[axis] + slack)):
            if not len(triangles):
                return False
            normal, origin = sign * np.eye(3)[axis], side * np.eye(3)[axis]
            vertices, triangles, _ = slice_faces_plane(vertices, triangles, normal, origin)
    return len(triangles) > 0


def misses(what: str, where: str, box: Box, points: Float[np.ndarray, "points 3"]) -> InputError:
    """The error of a box that does not hold what it should of a surface with these points [m]."""
    low, high = points.min(0), points.max(0)
    return InputError(
        what,
        where=where,
        value=f"{box.low.tolist()} to {box.high.tolist()} m",
        limit=f"a box that holds a part of the surface, {low.tolist()} to {high.tolist()} m",
        remedy="check the box's corners, in metres, against the surface",
    )


def _check_lamp(heater: Heater, surface: Surface, where: str) -> None:
    """Refuse a lamp whose axis passes far away, or that shines away from the object.

    A wide one would light it all the same, and one that is turned round its far side.
    """
    middle = (surface.vertices.min(0) + surface.vertices.max(0)) / 2
    away = float(np.linalg.norm(np.cross(middle - heater.centre, heater.direction)))
    size = surface.diagonal()
    if away > _PASSES * size:
        raise InputError(
            "the lamp's axis passes far from the object",
            where=f"{where}.centre",
            value=f"{away:.3g} m from the middle of an object of {size:.3g} m",
            limit=f"{_PASSES:g} times the object's diagonal, {_PASSES * size:.3g} m",
            remedy="give centre and radius in metres, and the surface's `unit` as its file has it; "
            "for even light, let a wide spot's axis pass through the object",
        )
    beside = _beside(heater, surface)
    if beside > _BESIDE * heater.radius:
        raise InputError(
            "the lamp's spot lies beside the object",
            where=f"{where}.centre",
            value=f"{heater.centre.tolist()} m, an axis that passes {beside:.3g} m beside what is "
            "turned to the light",
            limit=f"{_BESIDE:g} times its radius, {_BESIDE * heater.radius:.3g} m",
            remedy="check centre, direction and radius, in metres and in the surface's axes",
        )
    before = float(np.max((surface.vertices - heater.centre) @ heater.direction))
    if before < -SLACK * size:
        raise InputError(
            "the lamp shines away from the object",
            where=f"{where}.direction",
            value=f"{heater.direction.tolist()}, the object's nearest point {-before:.3g} m behind "
            f"the centre {heater.centre.tolist()} m",
            limit="an object that does not lie wholly behind the lamp's centre",
            remedy="give the way the light goes, from the lamp to the object",
        )


def _beside(heater: Heater, surface: Surface) -> float:
    """How far the axis passes beside all that is turned to the light, zero where it is met [m]."""
    corners = surface.vertices[surface.triangles] - heater.centre
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lit = corners[outward @ heater.direction < 0]
    # Seen along the light.
    seen = lit - (lit @ heater.direction)[..., None] * heater.direction
    return float(nearest_triangle(seen, np.zeros((1, 3)))[2][0])
