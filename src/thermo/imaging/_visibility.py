"""Which points of a surface a camera sees."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Bool, Float

from thermo.errors import InputError
from thermo.mesh import (
    Caster,
    Surface,
    caster_of,
    nearest_triangle,
    triangle_normals,
    unhindered,
)
from thermo.observe import check_number

from ._camera import Camera, project
from ._pixel_map import PixelMap, depth_at

# Below this cosine [1] (75 degrees off the normal) the tolerance no longer grows: a pixel's
# footprint becomes longer than folds are deep, and what lies behind a fold would pass. Less keeps
# more of steep faces and more of what is hidden: `benchmarks/visibility.py --steepest` prints both.
_STEEPEST: Final = 0.25
# The four pixels round a place, from the one at its upper left [px].
_ROUND: Final = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0))


def seen_by_depth(
    pixel_map: PixelMap,
    camera: Camera,
    surface: Surface,
    points: Float[np.ndarray, "points 3"],
    *,
    normals: Float[np.ndarray, "points 3"] | None = None,
    tolerance: float | None = None,
) -> Bool[np.ndarray, " points"]:
    """Whether points are seen, by the paper's rule: |z - D(u, v)| < eps.

    D is the depth that the nearest pixel sees. As the edge of what hides a point may pass between
    the point and that pixel's centre, none of the four pixels round it may see anything nearer than
    z - eps either. Each point stands for the point of the surface that is nearest to it. What lies
    outside of the frame, behind the camera, or on a face that is turned away is not seen.

    On the paper's bunny and car, seen from 24 places by 320 x 240 and 640 x 480 pixels, 0.04 % to
    0.3 % of what is kept is hidden after all, at the most 0.7 %; the nearest pixel alone would keep
    0.3 % to 1 %, at the most 1.7 %. Of what is seen a tenth is dropped, on steep faces and along
    silhouettes (`benchmarks/visibility.py`).

    Arguments:

    - `pixel_map`: of this camera and surface, as `look` makes it.
    - `points`: (points, 3) [m]. `normals`: outward at the points [1], any length; of the nearest
      face where left out.
    - `tolerance`: eps [m]; `depth_tolerance` of each point where left out.

    Raises `InputError` where the pixel map is of another frame or surface, for a tolerance that is
    not above 0, and for points that are not finite.

    Source: paper, appendix A.1, "Thermal Infrared Video Rendering" (checklist F7).
    """
    _check_map(pixel_map, camera, surface)
    if tolerance is not None:
        check_number(tolerance, where="tolerance", quantity="depth tolerance [m]", above=0.0)
    place, outward = on_surface(surface, points, normals)
    pixels, depth = project(camera, place)
    eps = depth_tolerance(camera, place, outward) if tolerance is None else tolerance
    with np.errstate(invalid="ignore"):
        near = np.abs(depth - depth_at(pixel_map, pixels)) < eps
        for step in _ROUND:
            near &= ~(depth - depth_at(pixel_map, np.floor(pixels) + step) >= eps)
    return near & (_cosines(camera, place, outward) > 0)


def seen_exactly(
    camera: Camera,
    surface: Surface,
    points: Float[np.ndarray, "points 3"],
    *,
    normals: Float[np.ndarray, "points 3"] | None = None,
) -> Bool[np.ndarray, " points"]:
    """Whether points are seen, by casting a ray at each: it must meet nothing before the point.

    Arguments and what is never seen: as for `seen_by_depth`, points in metres [m]. Points within
    1e-6 of the body's radius behind a silhouette may go either way.

    Raises `InputError` for points that are not finite.

    Source: checklist F7, the exact answer that the paper's rule is measured by.
    """
    return in_sight(camera, caster_of(surface), *on_surface(surface, points, normals))


def in_sight(
    camera: Camera,
    caster: Caster,
    places: Float[np.ndarray, "points 3"],
    normals: Float[np.ndarray, "points 3"],
) -> Bool[np.ndarray, " points"]:
    """`seen_exactly` for places on the surface [m] and normals there, with its caster."""
    pixels, depth = project(camera, places)
    with np.errstate(invalid="ignore"):
        framed = ((pixels >= -0.5) & (pixels < [camera.width - 0.5, camera.height - 0.5])).all(1)
    tried = np.flatnonzero(framed & (depth > 0) & (_cosines(camera, places, normals) > 0))
    seen = np.zeros(len(places), bool)
    seen[tried] = unhindered(caster, camera.place(), places[tried])
    return seen


def depth_tolerance(
    camera: Camera, points: Float[np.ndarray, "points 3"], normals: Float[np.ndarray, "points 3"]
) -> Float[np.ndarray, " points"]:
    """What depth may differ by between a point and the pixels round it [m].

    A plane of normal n, in the camera's axes, through a point of depth z that is seen along
    r = ((u - c_x) / f_x, (v - c_y) / f_y, 1) has the slope dz/du = -z n_x / (f_x n.r), and likewise
    for v. The centres of the four pixels round a point are at most one pixel off, so that

    eps = z (|n_x| / f_x + |n_y| / f_y) / max(|n.r|, 0.25 |n| |r|) + 1e-6 z.

    The nearest of them is at most half a pixel off; what is left of eps allows for faces that are
    inclined further than the point's own. Beyond 75 degrees from the normal eps grows no more:
    points of steeper faces are dropped rather than believed. A lens is left out of r and f.

    Arguments: `points` (points, 3) [m]; `normals` (points, 3), of any length [1].
    """
    seen = points @ camera.pose[:3, :3].T + camera.pose[:3, 3]
    turned = normals @ camera.pose[:3, :3].T
    depth = seen[:, 2]
    ray = seen / np.where(depth > 0, depth, 1.0)[:, None]
    longest = np.linalg.norm(turned, axis=1) * np.linalg.norm(ray, axis=1)
    across = np.maximum(np.abs(np.einsum("ij,ij->i", turned, ray)), _STEEPEST * longest)
    slope = (np.abs(turned[:, :2]) / camera.focal).sum(axis=1)
    return depth * (slope / np.where(across > 0, across, 1.0) + 1e-6)


def on_surface(
    surface: Surface,
    points: Float[np.ndarray, "points 3"],
    normals: Float[np.ndarray, "points 3"] | None = None,
) -> tuple[Float[np.ndarray, "points 3"], Float[np.ndarray, "points 3"]]:
    """The nearest points of the surface [m] and outward normals there [1]."""
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if bad.size:
        raise InputError(
            "a point is not finite", where="points",
            value=f"point {bad[0]}: {points[bad[0]].tolist()}", limit="finite metres",
            remedy="drop the points whose position is unknown",
        )  # fmt: skip
    own, _ = triangle_normals(surface.vertices, surface.triangles)
    corners = surface.vertices[surface.triangles]
    face, weights, _ = nearest_triangle(corners, points)
    place = np.einsum("pk,pki->pi", weights, corners[face])
    return place, own[face] if normals is None else normals


def _cosines(camera: Camera, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Of the angle between normal and line of sight, times their lengths; above 0 if facing."""
    return np.einsum("ij,ij->i", normals, camera.place() - points)


def _check_map(pixel_map: PixelMap, camera: Camera, surface: Surface) -> None:
    given = (*pixel_map.size(), pixel_map.vertices)
    wanted = (camera.height, camera.width, len(surface.vertices))
    if given != wanted:
        raise InputError(
            "this pixel map belongs to another view", where="pixel_map",
            value="{} rows, {} columns, {} vertices".format(*given),
            limit="{} rows, {} columns, {} vertices".format(*wanted),
            remedy="make it by `look(camera, surface)` of the same camera and surface",
        )  # fmt: skip
