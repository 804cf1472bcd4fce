"""Where a narrow beam meets the surface."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Float

from ._surface import Surface

RINGS: Final = 4
"""Rings of rays about the axis of a beam; the ring k holds 6 k of them."""


def in_beam(
    surface: Surface,
    centre: Float[np.ndarray, "3"],
    direction: Float[np.ndarray, "3"],
    radius: float,
) -> Float[np.ndarray, "points 3"]:
    """Points of the surface in a beam of 61 parallel rays, where it is turned to the light [m].

    What lies behind other parts is met as well, since a lamp here throws no shadow.

    Arguments:

    - `surface`: its triangles turned outward [m].
    - `centre`, `direction`: the beam's axis, a point [m] and a vector of length one.
    - `radius`: of the beam [m].
    """
    across = np.linalg.svd(direction[None])[2][1:]
    starts = centre + radius * _disc() @ across
    corners = surface.vertices[surface.triangles]
    flat = corners @ across.T
    low, high = flat.min(axis=1), flat.max(axis=1)
    axis = centre @ across.T
    one, two = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    # Twice the area that a triangle shows to the light.
    shown = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    near = (low <= axis + radius).all(axis=1) & (high >= axis - radius).all(axis=1)
    near &= (outward @ direction < 0.0) & (shown != 0.0)
    points = [np.zeros((0, 3))]
    for at in np.flatnonzero(near):
        away = starts @ across.T - flat[at, 0]
        second = (away[:, 0] * two[at, 1] - away[:, 1] * two[at, 0]) / shown[at]
        third = (one[at, 0] * away[:, 1] - one[at, 1] * away[:, 0]) / shown[at]
        weights = np.stack([1.0 - second - third, second, third], axis=1)
        points.append(weights[(weights >= -1e-9).all(axis=1)] @ corners[at])
    return np.concatenate(points)


def _disc() -> Float[np.ndarray, "rays 2"]:
    """Places spread evenly over the unit disc [1]."""
    places = [np.zeros((1, 2))]
    for ring in range(1, RINGS + 1):
        angle = 2 * np.pi * np.arange(6 * ring) / (6 * ring)
        places.append(ring / RINGS * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    return np.concatenate(places)
