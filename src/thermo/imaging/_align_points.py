"""The pose of an object whose surface meets a cloud of points."""

from __future__ import annotations

from typing import Final, final

import equinox as eqx
import numpy as np
import trimesh
from jaxtyping import Float, Int
from numpy.typing import ArrayLike
from scipy.spatial import KDTree

from thermo.mesh import Surface, triangle_normals
from thermo.observe import check_number

from ._align_descend import Descent, Matched, descend
from ._align_silhouettes import centre_and_size
from ._align_untold import inflation, knowledge
from ._point_cloud import as_cloud
from ._similarity import Similarity

_SAMPLES: Final = 50_000
"""Points spread over the surface, about [1]; between them the plane of the triangle counts."""

_SEED: Final = 0
"""Of these points, and of those that are drawn [1]."""

_ENOUGH: Final = 1e-6
"""A root mean square change of the distances that ends the descent, over the size [1]."""

_FLOOR: Final = 1e-5
"""What distances are off by at least, over the size [1]."""

_ALIKE: Final = 0.1
"""Distances of points this near each other may be off alike, over the size [1]."""

_MOST: Final = 20_000
"""Points that are matched at the most; of more, as many drawn at random [1]."""


@final
class PointAlignment(eqx.Module):
    """An object brought to where a cloud of points shows it.

    Arguments:

    - `similarity`: brings the surface from its own axes to the points'.
    - `residual`: deviation of the points from the surface, from the median of their size [m].
    - `inliers`: part of the points within three such deviations [1].
    - `deviation`: one standard deviation of the rotation vector [rad], of the shift of the
      object's centre [m] and of the logarithm of the scale [1], (7,), along the world's axes.
      Motions that are not told count with the size of the object.
    - `untold`: motions that the points do not tell, in words.
    - `success`: whether the descent converged and most points lie on the surface.
    - `reason`: in words.
    """

    similarity: Similarity
    residual: float
    inliers: float
    deviation: Float[np.ndarray, "7"]
    untold: tuple[str, ...] = eqx.field(static=True)
    success: bool = eqx.field(static=True)
    reason: str = eqx.field(static=True)


@final
class _Cover(eqx.Module):
    """Points spread over a surface [m], the triangle of each, and the triangles' normals [1]."""

    points: Float[np.ndarray, "cover 3"]
    triangle: Int[np.ndarray, " cover"]
    normals: Float[np.ndarray, "triangles 3"]
    tree: KDTree


def align_to_points(
    surface: Surface,
    points: ArrayLike,
    guess: Similarity | None = None,
    *,
    scale: bool = False,
    error: float = 0.01,
    where: str = "points",
) -> PointAlignment:
    """Turn, shift and, where asked for, scale a surface until it meets a cloud of points.

    Each point is matched with the nearest point of the surface; residuals are the distances from
    that one's plane, n (p - q) [m]. Damped Gauss-Newton steps lessen them under Tukey's loss, which
    leaves out points far off, and points are matched anew after each step. The start must be near
    enough that most points find the right side: some 20 degrees and a tenth of the size. Of more
    than 20 000 points as many are drawn. Neighbours' distances that are off alike count as fewer in
    the deviations; what all points have in common, such as their scale, is not in them.

    Arguments:

    - `surface`: in its own axes [m], closed and turned outward.
    - `points`: of the cloud, (points, 3) [m], over a part of the surface or all of it.
    - `guess`: brings the surface to about where the points are; as it stands where left out.
    - `scale`: whether the scale is free too.
    - `error`: what points may lie off the surface, over the diagonal of its box [1]; a fit that
      leaves more is reported as failed. `where`: what messages call the points.

    Raises `InputError` for fewer than 12 points, and for points that are not finite.

    Source: Chen and Medioni, Image and Vision Computing 10 (1992) 145.
    """
    check_number(error, where="error", quantity="distance over the size [1]", above=0.0)
    cloud = as_cloud(points, where=where)
    if len(cloud) > _MOST:
        cloud = cloud[np.random.default_rng(_SEED).choice(len(cloud), _MOST, replace=False)]
    start = Similarity() if guess is None else guess
    cover = _cover(surface)
    middle, size = centre_and_size(surface)
    floor = _FLOOR * surface.diagonal() * start.scale

    def match(pose: Similarity) -> Matched:
        _, near = cover.tree.query(pose.inverse().apply(cloud))
        on = pose.apply(cover.points[near])
        normals = cover.normals[cover.triangle[near]] @ pose.rotation.T
        off = np.einsum("ij,ij->i", on - cloud, normals)
        return Matched(off, on, normals, floor)

    enough = _ENOUGH * surface.diagonal() * start.scale
    found = descend(match, start, middle, size, scale=scale, enough=enough)
    matched, there = found.matched, surface.diagonal() * found.similarity.scale
    weighted = matched.weights() * matched.residual
    alike = inflation([(cloud, weighted)], _ALIKE * there, 6 + scale)
    told = knowledge(match, found, middle, size, scale=scale, inflation=alike)
    spread = matched.spread()
    inliers = float(np.mean(np.abs(matched.residual) < 3 * spread))
    reason = _failure(found, cloud, error * there)
    return PointAlignment(
        found.similarity, spread, inliers, told.deviation, told.untold,
        not reason, reason or f"converged in {found.steps} steps",
    )  # fmt: skip


def _failure(found: Descent, cloud: Float[np.ndarray, "points 3"], most: float) -> str:
    """Why the fit is not to be believed, or nothing; `most`, what points may be off [m]."""
    if not found.converged:
        return f"no convergence in {found.steps} steps"
    spread = found.matched.spread()
    if spread > most:
        return f"points {spread:.3g} m off the surface, more than {most:.3g} m"
    near = float(np.mean(np.linalg.norm(found.matched.points - cloud, axis=1) < 3 * most))
    return "" if near > 0.5 else f"{near:.0%} of the points near the surface, no more than half"


def _cover(surface: Surface) -> _Cover:
    """Points drawn at random, as dense everywhere, and the middles of all triangles."""
    normals, _ = triangle_normals(surface.vertices, surface.triangles)
    whole = trimesh.Trimesh(surface.vertices, surface.triangles, process=False)
    drawn, triangle = trimesh.sample.sample_surface(whole, _SAMPLES, seed=_SEED)[:2]
    points = np.concatenate([drawn, surface.vertices[surface.triangles].mean(axis=1)])
    every = np.concatenate([triangle, np.arange(len(normals))])
    return _Cover(points, every, normals, KDTree(points))
