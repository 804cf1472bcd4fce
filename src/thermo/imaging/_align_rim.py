"""The rim of a surface as a camera sees it: where front meets back, against the sky."""

from __future__ import annotations

from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial import KDTree

from thermo.errors import InputError
from thermo.mesh import Surface, triangle_normals

from ._camera import Camera, project
from ._silhouette import covered, lines_of_sight
from ._similarity import Similarity

_NEAR: Final = 3.0
"""Normals of the rim are averaged over what lies this near [px]."""

_OUT: Final = 1.5
"""What lies this far outside of the rim is background [px]."""


@final
class Outline(eqx.Module):
    """A surface with what its rim needs, in the object's own axes.

    Arguments: `vertices` (vertices, 3) [m]; `triangles`; `normals` of the triangles [1]; `edges`
    between two triangles each, and `sides`, these triangles.
    """

    vertices: Float[np.ndarray, "vertices 3"]
    triangles: Int[np.ndarray, "triangles 3"]
    normals: Float[np.ndarray, "triangles 3"]
    edges: Int[np.ndarray, "edges 2"]
    sides: Int[np.ndarray, "edges 2"]


@final
class Sight(eqx.Module):
    """A camera, its place [m] and its lines of sight [1] in its own axes."""

    camera: Camera
    place: Float[np.ndarray, "3"]
    lines: Float[np.ndarray, "pixels 3"]


@final
class Rim(eqx.Module):
    """Points of the rim that a camera sees.

    Arguments: `points` in the world (rim, 3) [m]; `pixels`, where they are seen (rim, 2) [px];
    `outward`, the contour's normal in the picture (rim, 2) [1]; `slope` (rim, 3) [px/m], what the
    contour moves outward as its point moves; `mask`, what the surface covers.
    """

    points: Float[np.ndarray, "rim 3"]
    pixels: Float[np.ndarray, "rim 2"]
    outward: Float[np.ndarray, "rim 2"]
    slope: Float[np.ndarray, "rim 3"]
    mask: Bool[np.ndarray, "rows columns"]


def outline(surface: Surface) -> Outline:
    """Edges and normals [1] of a surface [m]; edges of more or less than two sides are left out.

    Raises `InputError` where no edge is left.
    """
    sides = surface.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).astype(np.int64)
    edges, which, counts = np.unique(
        np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    order = np.argsort(which.ravel(), kind="stable")
    first = np.cumsum(counts) - counts
    pair = counts == 2
    if not pair.any():
        raise InputError(
            "this surface has no edge between two triangles", where="surface",
            value=f"{len(surface.triangles)} triangles", limit="a closed surface",
            remedy="check it with `check_surface`",
        )  # fmt: skip
    beside = np.stack([order[first[pair]], order[first[pair] + 1]], axis=1) // 3
    normals, _ = triangle_normals(surface.vertices, surface.triangles)
    return Outline(surface.vertices, surface.triangles, normals, edges[pair], beside)


def sight_of(camera: Camera) -> Sight:
    """What is computed once for a camera: its place [m] and lines of sight [1]."""
    return Sight(camera, camera.place(), lines_of_sight(camera))


def rim_of(body: Outline, sight: Sight, pose: Similarity) -> Rim:
    """The rim of a body at a pose: one point a pixel of the contour, inside of the frame.

    On an edge between a front and a back the normal that lies across the line of sight, mixed from
    the two triangles' normals, moves the contour; the point's motion along the surface does not.
    Lens distortion bends the direction of these normals by what it turns a pixel, which is left
    out.

    Source: Cipolla and Giblin, Visual Motion of Curves and Surfaces (2000), chapter 2 (contour
    generators and their motion).
    """
    camera = sight.camera
    vertices = pose.apply(body.vertices)
    mask = covered(camera, sight.lines, vertices, body.triangles)
    normals = body.normals @ pose.rotation.T
    towards = sight.place - vertices[body.triangles[:, 0]]
    front = np.einsum("ij,ij->i", normals, towards) > 0
    rim = front[body.sides[:, 0]] != front[body.sides[:, 1]]
    points, sides = _points(camera, vertices, body.edges[rim], body.sides[rim])
    pixels, depth = project(camera, points)
    seen = np.isfinite(pixels).all(axis=1)
    points, sides, pixels, depth = points[seen], sides[seen], pixels[seen], depth[seen]
    view = points - sight.place
    one, other = normals[sides[:, 0]], normals[sides[:, 1]]
    near, far = (np.einsum("ij,ij->i", n, view)[:, None] for n in (one, other))
    across = (one * far - other * near) / np.where(far == near, 1.0, far - near)
    across = _averaged(across, pixels)
    view /= np.linalg.norm(view, axis=1, keepdims=True)
    across -= np.einsum("ij,ij->i", across, view)[:, None] * view
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
    flat = (across @ camera.pose[:3, :3].T)[:, :2] / camera.focal
    length = np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-12)
    kept = _against_sky(mask, pixels, flat / length)
    slope = across / (length * depth[:, None])
    return Rim(points[kept], pixels[kept], (flat / length)[kept], slope[kept], mask)


def _points(
    camera: Camera,
    vertices: Float[np.ndarray, "vertices 3"],
    edges: Int[np.ndarray, "rim 2"],
    sides: Int[np.ndarray, "rim 2"],
) -> tuple[Float[np.ndarray, "points 3"], Int[np.ndarray, "points 2"]]:
    """Points on edges, about one a pixel, and the triangles beside them."""
    ends = vertices[edges]
    pixels = project(camera, ends.reshape(-1, 3))[0].reshape(-1, 2, 2)
    length = np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=1)
    most = camera.width + camera.height
    counts = np.clip(np.nan_to_num(np.ceil(length), nan=1.0), 1, most).astype(np.int64)
    which = np.repeat(np.arange(len(edges)), counts)
    step = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    along = ((step + 0.5) / counts[which])[:, None]
    return (1 - along) * ends[which, 0] + along * ends[which, 1], sides[which]


def _averaged(
    normals: Float[np.ndarray, "rim 3"], pixels: Float[np.ndarray, "rim 2"]
) -> Float[np.ndarray, "rim 3"]:
    """Normals averaged over the neighbours: a rim of small triangles runs in zigzag."""
    if len(pixels) < 2:
        return normals
    _, close = KDTree(pixels).query(pixels, k=min(12, len(pixels)), distance_upper_bound=_NEAR)
    padded = np.concatenate([normals, np.zeros((1, 3))])
    # A rim that runs close to another, back to back, is no neighbour.
    alike = np.einsum("ikj,ij->ik", padded[close], normals) > 0
    return (padded[close] * alike[..., None]).sum(axis=1)


def _against_sky(
    mask: Bool[np.ndarray, "rows columns"],
    pixels: Float[np.ndarray, "rim 2"],
    outward: Float[np.ndarray, "rim 2"],
) -> Int[np.ndarray, " kept"]:
    """Points beyond which nothing is covered and no other rim runs, in the frame, one a pixel."""
    size = np.array([mask.shape[1], mask.shape[0]])
    out = np.rint(pixels + _OUT * outward).astype(np.int64)
    inside = ((out >= 0) & (out < size) & (pixels >= 0) & (pixels <= size - 1)).all(axis=1)
    which = np.flatnonzero(inside)
    which = which[~mask[out[which, 1], out[which, 0]]]
    which = which[~_behind(pixels[which], outward[which])]
    cell = np.rint(pixels[which]).astype(np.int64)
    _, first = np.unique(cell[:, 1] * size[0] + cell[:, 0], return_index=True)
    return which[first]


def _behind(
    pixels: Float[np.ndarray, "rim 2"], outward: Float[np.ndarray, "rim 2"]
) -> Bool[np.ndarray, " rim"]:
    """Whether another point of the rim lies right outside of each one."""
    if len(pixels) < 2:
        return np.zeros(len(pixels), bool)
    far, close = KDTree(pixels).query(pixels, k=min(24, len(pixels)), distance_upper_bound=2.0)
    other = np.concatenate([pixels, np.zeros((1, 2))])[close] - pixels[:, None]
    up = np.einsum("ikj,ij->ik", other, outward)
    beside = np.abs(other[..., 0] * outward[:, None, 1] - other[..., 1] * outward[:, None, 0])
    return (np.isfinite(far) & (up > 0.3) & (beside < 0.5)).any(axis=1)
