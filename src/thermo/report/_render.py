"""A small renderer: which face of a closed surface each pixel of a parallel projection sees.

Matplotlib's own 3-D axes sort whole polygons by the depth of their centres, which shows hidden
faces through thin walls. A depth for each pixel does not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from jaxtyping import Float, Int

# Triangles are drawn in groups that touch about so many pixels, to bound the memory.
_GROUP = 2_000_000


@final
@dataclass(frozen=True)
class Camera:
    """A parallel projection.

    - `axes`: rows are the directions right, up and towards the viewer [1].
    - `corner`: lower left corner of the picture along right and up [m].
    - `pixel`: edge length of a pixel [m].
    - `width`, `height`: number of pixels.
    """

    axes: Float[np.ndarray, "3 3"]
    corner: Float[np.ndarray, " 2"]
    pixel: float
    width: int
    height: int

    def project(self, points: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, "points 3"]:
        """Column, row (from below) and depth (more is nearer), all in pixels."""
        seen = points @ self.axes.T
        seen[:, :2] -= self.corner
        return seen / self.pixel

    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top of the picture [m]."""
        left, bottom = (float(c) for c in self.corner)
        return left, left + self.width * self.pixel, bottom, bottom + self.height * self.pixel


@final
@dataclass(frozen=True)
class View:
    """What each pixel sees: the face or -1, its depth [pixel], and its brightness in 0 to 1."""

    camera: Camera
    face: Int[np.ndarray, "height width"]
    depth: Float[np.ndarray, "height width"]
    light: Float[np.ndarray, "height width"]


def camera_axes(azimuth: float, elevation: float) -> Float[np.ndarray, "3 3"]:
    """Directions right, up and towards a viewer at these angles [rad]; z is up in the world."""
    ca, sa, ce, se = np.cos(azimuth), np.sin(azimuth), np.cos(elevation), np.sin(elevation)
    return np.array([[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])


def corner_normals(
    nodes: Float[np.ndarray, "nodes 3"], faces: Int[np.ndarray, "faces 3"]
) -> Float[np.ndarray, "faces 3 3"]:
    """Unit normals at the corners of each face.

    The mean, weighted by area, over the faces around the node that lean less than about 35
    degrees from this one: curved parts look smooth and edges stay sharp.
    """
    a, b, c = (nodes[faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    unit = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    # All pairs of corners at one node: corner k of the flat list, and every corner beside it.
    node = faces.ravel()
    by_node = np.argsort(node, kind="stable")
    count = np.bincount(node, minlength=len(nodes))
    first = np.cumsum(count) - count
    repeats = count[node]
    corner = np.repeat(np.arange(node.size), repeats)
    step = np.arange(repeats.sum()) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    beside = by_node[first[node[corner]] + step] // 3
    near = np.einsum("pi,pi->p", unit[corner // 3], unit[beside]) > 0.82
    corner, beside = corner[near], beside[near]
    mean = np.stack(
        [np.bincount(corner, normal[beside, i], minlength=node.size) for i in range(3)], axis=1
    )
    mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), np.finfo(float).tiny)
    return mean.reshape(-1, 3, 3)


def _candidates(low: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangle, column and row of every pixel in the box of each triangle."""
    counts = size[:, 0] * size[:, 1]
    triangle = np.repeat(np.arange(len(counts)), counts)
    index = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    row, column = np.divmod(index, size[triangle, 0])
    return triangle, column + low[triangle, 0], row + low[triangle, 1]


def _draw(
    view: View,
    corners: Float[np.ndarray, "faces 3 3"],
    brightness: Float[np.ndarray, "faces 3"],
    names: Int[np.ndarray, " faces"],
) -> None:
    """Draws a group of front faces into the view where they are nearer than what it holds."""
    limit = np.array([view.camera.width, view.camera.height])
    flat = corners[..., :2]
    low = np.clip(np.ceil(flat.min(axis=1) - 0.5).astype(int), 0, limit)
    high = np.clip(np.floor(flat.max(axis=1) - 0.5).astype(int) + 1, 0, limit)
    triangle, column, row = _candidates(low, np.maximum(high - low, 0))
    # Barycentric coordinates of the centre of the pixel.
    a, ab, ac = flat[:, 0], flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    x, y = column + 0.5 - a[triangle, 0], row + 0.5 - a[triangle, 1]
    v = (x * ac[triangle, 1] - y * ac[triangle, 0]) / area[triangle]
    w = (y * ab[triangle, 0] - x * ab[triangle, 1]) / area[triangle]
    inside = (v >= -1e-9) & (w >= -1e-9) & (v + w <= 1 + 1e-9)
    triangle, column, row = triangle[inside], column[inside], row[inside]
    v, w = v[inside], w[inside]
    weights = np.stack([1 - v - w, v, w], axis=1)
    depth = np.einsum("pi,pi->p", weights, corners[triangle, :, 2])
    # Written in the order of depth, the nearest stays.
    order = np.argsort(depth)
    order = order[depth[order] > view.depth[row[order], column[order]]]
    pixels = row[order], column[order]
    view.depth[pixels] = depth[order]
    view.face[pixels] = names[triangle[order]]
    view.light[pixels] = np.einsum("pi,pi->p", weights, brightness[triangle])[order]


def render(
    nodes: Float[np.ndarray, "nodes 3"], faces: Int[np.ndarray, "faces 3"], camera: Camera
) -> View:
    """What each pixel of `camera` sees of the closed surface `nodes` [m], `faces`.

    Faces are ordered counter-clockwise from outside; those that look away are left out.
    """
    shape = (camera.height, camera.width)
    view = View(camera, np.full(shape, -1), np.full(shape, -np.inf), np.zeros(shape))
    # The light comes from above the viewer's left shoulder.
    source = np.array([-0.35, 0.45, 0.82]) @ camera.axes
    brightness = np.clip(corner_normals(nodes, faces) @ (source / np.linalg.norm(source)), 0, 1)
    corners = camera.project(nodes)[faces]
    side = corners[:, 1:, :2] - corners[:, :1, :2]
    front = np.flatnonzero(side[:, 0, 0] * side[:, 1, 1] - side[:, 0, 1] * side[:, 1, 0] > 1e-12)
    size = np.prod(np.ptp(corners[front, :, :2], axis=1) + 1.0, axis=1)
    groups = (np.cumsum(size) // _GROUP).astype(int)
    for group in np.split(front, np.flatnonzero(np.diff(groups)) + 1):
        _draw(view, corners[group], brightness[group], group)
    return view


def visible(view: View, points: Float[np.ndarray, "points 3"], slack: float) -> np.ndarray:
    """Which points [m] no face hides by more than `slack` [m], (points,) truth values."""
    column, row, depth = view.camera.project(points).T
    column = np.clip(column.astype(int), 0, view.camera.width - 1)
    row = np.clip(row.astype(int), 0, view.camera.height - 1)
    return depth >= view.depth[row, column] - slack / view.camera.pixel
