"""Closest points of triangles."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", a, b)


def closest_on_triangles(
    corners: Float[np.ndarray, "... 3 3"], points: Float[np.ndarray, "... 3"]
) -> tuple[Float[np.ndarray, "... 3"], Float[np.ndarray, "..."]]:
    """Barycentric coordinates of the closest point of a triangle, and the distance to it [m].

    The projection on the plane is taken where it falls inside; otherwise the closest of the
    three edges. Triangles without area are handled as their edges.
    """
    points = np.broadcast_to(points, corners.shape[:-2] + (3,))
    inside, best = _on_plane(corners, points)
    gap = np.linalg.norm(np.einsum("...k,...ki->...i", best, corners) - points, axis=-1)
    gap = np.where(inside, gap, np.inf)
    for first, second in ((0, 1), (1, 2), (2, 0)):
        start, along = corners[..., first, :], corners[..., second, :] - corners[..., first, :]
        length = np.maximum(_dot(along, along), np.finfo(float).tiny)
        share = np.clip(_dot(points - start, along) / length, 0.0, 1.0)
        here = np.linalg.norm(start + share[..., None] * along - points, axis=-1)
        weights = np.zeros_like(best)
        weights[..., first], weights[..., second] = 1.0 - share, share
        closer = here < gap
        best = np.where(closer[..., None], weights, best)
        gap = np.where(closer, here, gap)
    return best, gap


def _on_plane(corners: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Barycentric coordinates of the projection on the plane, and whether it falls inside."""
    u = corners[..., 1, :] - corners[..., 0, :]
    v = corners[..., 2, :] - corners[..., 0, :]
    w = points - corners[..., 0, :]
    normal = np.cross(u, v)
    square = _dot(normal, normal)
    safe = np.where(square > 0.0, square, 1.0)
    third = _dot(np.cross(u, w), normal) / safe
    second = _dot(np.cross(w, v), normal) / safe
    weights = np.stack([1.0 - second - third, second, third], axis=-1)
    return (weights >= 0.0).all(axis=-1) & (square > 0.0), weights
