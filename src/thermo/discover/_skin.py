"""The skin that a patch with an edge lies on, and that a lamp lights."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from thermo.discover._candidate import Inclusion
from thermo.mesh import Mesh, face_areas, face_centres
from thermo.observe import Run

# How far an axis goes across a flat skin at the least, and how much of a patch is on that [1].
_ACROSS: Final = 0.98
_MOST: Final = 0.95
# Along each side of a face how many points of it are looked at: a strip may lie between centres.
_POINTS: Final = 6
# Of the light where a lamp is brightest, what counts as lit [1].
_LIT: Final = 0.05


def across_skin(place: Inclusion, part: int, mesh: Mesh) -> Float[np.ndarray, "3"]:
    """How far each axis [1] goes across the skin where that is nearest to a place [m]."""
    return np.abs(mesh.normals[_nearest(place, part, mesh)])


def flat_across(place: Inclusion, part: int, mesh: Mesh) -> Bool[np.ndarray, "3"]:
    """Which axis goes straight across the skin where most of a patch lies; none on a round one.

    Along it neither the patch's middle nor its size means anything, as what lies deeper and is
    stronger is the same to the skin.
    """
    share = np.asarray(place.only(part).shapes(jnp.asarray(_over_faces(mesh)))[0])
    covered = share.mean(axis=0) * face_areas(mesh)
    there = covered @ (np.abs(mesh.normals) > _ACROSS)
    return (there >= _MOST * covered.sum()) & (there > 0)


def _over_faces(mesh: Mesh) -> Float[np.ndarray, "points faces 3"]:
    """Points [m] spread evenly over each face, the middles of triangles that it is cut into."""
    cut = np.arange(_POINTS)
    one, other = (way.ravel() for way in np.meshgrid(cut, cut, indexing="ij"))
    # Those that stand as the face does, and those between them, upside down.
    parts = [(one + 1 / 3, other + 1 / 3), (one + 2 / 3, other + 2 / 3)]
    along, up = np.concatenate(parts, axis=1) / _POINTS
    inside = along + up < 1
    weights = np.stack([1 - along - up, along, up], axis=1)[inside]
    return np.einsum("pk,fkx->pfx", weights, mesh.nodes[mesh.faces[:, :3]])


def on_skin(place: Inclusion, part: int, mesh: Mesh) -> Float[np.ndarray, "3"]:
    """The middle of a patch [m], moved onto the skin along an axis that goes across a flat one."""
    nearest = face_centres(mesh)[_nearest(place, part, mesh)]
    middle = np.asarray(place.centre[part])
    return np.where(flat_across(place, part, mesh), nearest, middle)


def lit_skin(runs: Sequence[Run], mesh: Mesh) -> Float[np.ndarray, "points 3"]:
    """Middles of the faces [m] on which lamps of the runs shine, but for the rim of their light."""
    # Each face that is lit: the rays of `in_beam` are too far apart in wide light.
    middles, lit = face_centres(mesh), np.zeros(len(mesh.faces), bool)
    for lamp in (run.heater for run in runs if run.heater is not None):
        way = np.asarray(lamp.direction) / np.linalg.norm(lamp.direction)
        off = middles - np.asarray(lamp.centre)
        across = np.sum(off**2, axis=1) - (off @ way) ** 2
        light = np.maximum(-mesh.normals @ way, 0.0) * np.exp(-across / (2 * lamp.radius**2))
        lit |= light > _LIT * light.max()
    return middles[lit]


def _nearest(place: Inclusion, part: int, mesh: Mesh) -> int:
    apart = face_centres(mesh) - np.asarray(place.centre[part])
    return int(np.argmin(np.sum(apart**2, axis=1)))
