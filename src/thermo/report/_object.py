"""The object in two opposite views, as both kinds of picture of it need it."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int
from matplotlib.axes import Axes

from ._render import Camera, View, camera_axes, render

# Opposite sides from above: together they show all but the underside.
ANGLES = ((np.radians(-60.0), np.radians(28.0)), (np.radians(120.0), np.radians(28.0)))
_PIXELS = 600  # along the longer side of a view, before oversampling
_OVERSAMPLING = 2
_MARGIN = 0.04


def two_views(
    nodes: Float[np.ndarray, "nodes 3"], faces: Int[np.ndarray, "faces corners"]
) -> list[View]:
    """Two rendered views at one scale of the surface `nodes` [m], `faces` (f, 3) or (f, 6)."""
    corners = np.asarray(faces)[:, :3]
    used = nodes[np.unique(corners)]
    boxes = []
    for azimuth, elevation in ANGLES:
        axes = camera_axes(azimuth, elevation)
        flat = used @ axes[:2].T
        boxes.append((axes, flat.min(axis=0), flat.max(axis=0)))
    size = np.max([high - low for _, low, high in boxes], axis=0) * (1 + 2 * _MARGIN)
    pixel = float(size.max()) / (_PIXELS * _OVERSAMPLING)
    # Even numbers of pixels, so that they can be averaged in blocks.
    width, height = (int(_OVERSAMPLING * np.ceil(s / pixel / _OVERSAMPLING)) for s in size)
    half = 0.5 * pixel * np.array([width, height])
    cameras = [
        Camera(axes, (low + high) / 2 - half, pixel, width, height) for axes, low, high in boxes
    ]
    return [render(nodes, corners, camera) for camera in cameras]


def draw_view(axes: Axes, view: View, colours: Float[np.ndarray, "faces 3"]) -> None:
    """Shows a view with a colour for each face (red, green, blue in 0 to 1), shaded."""
    seen = view.face >= 0
    picture = np.ones((*view.face.shape, 3))
    light = view.light[seen][:, None]
    shaded = colours[view.face[seen]] * (0.62 + 0.38 * light)
    # A little white keeps the form of dark colours readable.
    picture[seen] = shaded + 0.2 * light**2 * (1 - shaded)
    # A thin dark line where a nearer part covers a farther one makes the form easier to read.
    depth = np.where(seen, view.depth, -np.inf)
    for axis in (0, 1):
        far, near = (np.roll(depth, s, axis=axis) for s in (1, -1))
        with np.errstate(invalid="ignore"):
            step = np.maximum(depth - far, depth - near)
        picture[seen & np.isfinite(step) & (step > 0.03 * _PIXELS * _OVERSAMPLING)] *= 0.6
    n = _OVERSAMPLING
    height, width = view.face.shape
    picture = picture.reshape(height // n, n, width // n, n, 3).mean(axis=(1, 3))
    axes.imshow(picture, origin="lower", extent=view.camera.extent(), interpolation="antialiased")
    axes.set_axis_off()


def length_text(length: float) -> str:
    """A length [m] in millimetres, or in metres from one metre on."""
    return f"{length:g} m" if length >= 1 else f"{length * 1e3:g} mm"


def round_length(length: float) -> float:
    """The longest of 1, 2 or 5 times a power of ten that is not longer than `length` [m]."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(max(f for f in (1.0, 2.0, 5.0) if f * power <= length * (1 + 1e-9)) * power)


def draw_scale(axes: Axes, view: View) -> None:
    """A bar of a round length, and the directions of x, y and z, below the object."""
    left, right, bottom, top = view.camera.extent()
    length = round_length((right - left) / 3)
    gap = 0.06 * max(right - left, top - bottom)
    y = bottom - gap
    axes.plot([right - length, right], [y, y], color="0.25", lw=2, solid_capstyle="butt")
    axes.annotate(
        length_text(length), (right - length / 2, y), (0, -4), textcoords="offset points",
        ha="center", va="top", fontsize=8, color="0.25",
    )  # fmt: skip
    origin = np.array([left + 2.2 * gap, y - 0.4 * gap])
    for name, colour, direction in zip(
        "xyz", ("#b03030", "#2f7d32", "#2f4fb0"), view.camera.axes[:2].T, strict=True
    ):
        tip, text = origin + 1.3 * gap * direction, origin + 1.7 * gap * direction
        arrow = {"arrowstyle": "-|>", "color": colour, "lw": 1}
        axes.annotate("", tuple(tip), tuple(origin), arrowprops=arrow, annotation_clip=False)
        axes.text(text[0], text[1], name, ha="center", va="center", fontsize=8, color=colour)
    axes.set_xlim(left, right)
    axes.set_ylim(y - 2.2 * gap, top)
