"""What a camera would see of a surface."""

from __future__ import annotations

from typing import Final

import numpy as np
import trimesh
from jaxtyping import Float

from thermo.errors import InputError
from thermo.mesh import Surface, caster_of, triangle_normals, unhindered

# Points tried for each one wanted; rounds after which what was found is enough [1].
_TRIED: Final = 4
_ROUNDS: Final = 8


def seen_from(
    surface: Surface,
    camera: Float[np.ndarray, "3"],
    count: int,
    *,
    seed: int = 0,
    where: str = "camera",
) -> Float[np.ndarray, "samples 3"]:
    """Points of a surface that a camera sees, as dense as its pixels [m].

    Each pixel takes in as much solid angle as the next, so that the points on a surface at distance
    r, inclined by theta, are as dense as cos(theta) / r^2. What another part of the surface hides
    is not seen.

    Arguments:

    - `surface`: checked, turned outward [m]; `camera`: where it stands [m].
    - `count`: how many points [1], drawn with `seed`; fewer where little of the surface is seen.
    - `where`: what messages call the camera.

    Raises `InputError` where nothing is seen.

    Source: the form factor of a small surface to a point, Modest, Radiative Heat Transfer (2013),
    chapter 4.
    """
    random = np.random.default_rng(seed)
    corners = surface.vertices[surface.triangles]
    normals, _ = triangle_normals(surface.vertices, surface.triangles)
    front = np.einsum("ij,ij->i", normals, camera - corners[:, 0]) > 0
    if not front.any():
        raise _unseen(camera, where)
    normals, caster = normals[front], caster_of(surface)
    near = trimesh.Trimesh(surface.vertices, surface.triangles[front], process=False)
    found = []
    for _ in range(_ROUNDS):
        points, picked = trimesh.sample.sample_surface(near, _TRIED * count, seed=random)[:2]
        away = camera - points
        length = np.linalg.norm(away, axis=1)
        dense = np.einsum("ij,ij->i", normals[picked], away) / length**3
        kept = random.random(len(points)) < dense / dense.max()
        points = points[kept]
        found.append(points[unhindered(caster, camera, points)])
        if sum(map(len, found)) >= count:
            break
    every = np.concatenate(found)[:count]
    if len(every) == 0:
        raise _unseen(camera, where)
    return every


def _unseen(camera: Float[np.ndarray, "3"], where: str) -> InputError:
    return InputError(
        "this camera sees nothing of the body", where=where,
        value=", ".join(f"{one:g}" for one in camera), limit="a place outside of it [m]",
        remedy="give the place in the axes of the surface, in metres",
    )  # fmt: skip
