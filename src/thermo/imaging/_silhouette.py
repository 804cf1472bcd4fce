"""Silhouettes: which pixels of a camera a surface covers, rendered and found in frames."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import ndimage

from thermo.errors import InputError
from thermo.mesh import Surface

from ._camera import Camera, pixel_centres, project, rays
from ._frames import Frames

_AT_ONCE: Final = 1_000_000
"""Pairs of triangle and pixel that are tried at once, to bound the memory."""

_APART: Final = 4.0
"""Least distance of the two means over the deviation within the two [1].

The best threshold cuts normal noise into two parts that are 2.65 deviations apart and evenly spread
values into two that are 3.46 apart, though neither holds an object.
"""


def silhouette(camera: Camera, surface: Surface) -> Bool[np.ndarray, "rows columns"]:
    """Which pixels see the surface: those whose line of sight through their centre meets it.

    A line of sight r meets a triangle with corners a, b, c as seen from the camera where the three
    volumes r (a x b), r (b x c) and r (c x a) are of one sign. Lines of sight are those of the
    lens. Only triangles that lie wholly before the camera are seen.

    Arguments: `surface` [m], closed: triangles turned away from the camera are left out.

    Source: edge functions, Pineda, Computer Graphics 22 (1988) 17; in homogeneous form, Olano and
    Greer, Graphics Hardware (1997) 89.
    """
    sight = lines_of_sight(camera)
    return covered(camera, sight, surface.vertices, surface.triangles)


def lines_of_sight(camera: Camera) -> Float[np.ndarray, "pixels 3"]:
    """Directions [1] of all pixels in the camera's own axes, row after row."""
    return rays(camera, pixel_centres(camera)) @ camera.pose[:3, :3].T


def covered(
    camera: Camera,
    sight: Float[np.ndarray, "pixels 3"],
    vertices: Float[np.ndarray, "vertices 3"],
    triangles: Int[np.ndarray, "triangles 3"],
) -> Bool[np.ndarray, "rows columns"]:
    """`silhouette` for vertices [m], with `lines_of_sight` [1] computed before."""
    mask = np.zeros(camera.height * camera.width, bool)
    seen = vertices @ camera.pose[:3, :3].T + camera.pose[:3, 3]
    a, b, c = (seen[triangles[:, i]] for i in range(3))
    planes = np.stack([np.cross(a, b), np.cross(b, c), np.cross(c, a)], axis=1)
    front = np.einsum("ij,ij->i", planes[:, 0], c) < 0
    front &= (np.stack([a, b, c])[..., 2] > 0).all(axis=0)
    planes = planes[front]
    first, size = _boxes(camera, vertices, triangles[front])
    counts = size.prod(axis=1)
    ends = np.cumsum(counts)
    begin = 0
    while begin < len(counts):
        done = ends[begin - 1] if begin else 0
        end = max(begin + 1, int(np.searchsorted(ends, done + _AT_ONCE)))
        part = slice(begin, end)
        which = np.repeat(np.arange(begin, end), counts[part])
        inside = np.arange(len(which)) - np.repeat(ends[part] - counts[part] - done, counts[part])
        row, column = np.divmod(inside, size[which, 0])
        pixel = (row + first[which, 1]) * camera.width + column + first[which, 0]
        sides = np.einsum("ijk,ik->ij", planes[which], sight[pixel])
        mask[pixel[(sides <= 0).all(axis=1)]] = True
        begin = end
    return mask.reshape(camera.height, camera.width)


def _boxes(
    camera: Camera,
    vertices: Float[np.ndarray, "vertices 3"],
    triangles: Int[np.ndarray, "triangles 3"],
) -> tuple[Int[np.ndarray, "triangles 2"], Int[np.ndarray, "triangles 2"]]:
    """First column and row, and numbers of columns and rows, of the pixels in each one's box."""
    corners = vertices[triangles]
    if np.any(camera.distortion):
        # A lens bends edges: their middles count twice, which bounds an arc that bulges out.
        flat = project(camera, vertices)[0][triangles]
        middles = (corners + np.roll(corners, -1, axis=1)) / 2
        bent = project(camera, middles.reshape(-1, 3))[0].reshape(flat.shape)
        out = 2 * (bent - (flat + np.roll(flat, -1, axis=1)) / 2)
        pixels = np.concatenate([flat, bent + out], axis=1)
    else:
        pixels = project(camera, vertices)[0][triangles]
    edge = np.array([camera.width, camera.height]) - 1
    # A thousandth of a pixel keeps centres that lie on an edge, whatever the rounding.
    low = np.clip(np.ceil(pixels.min(axis=1) - 1e-3), 0, edge + 1).astype(np.int64)
    high = np.clip(np.floor(pixels.max(axis=1) + 1e-3), -1, edge).astype(np.int64)
    return low, np.maximum(high - low + 1, 0)


def overlap(
    one: Bool[np.ndarray, "rows columns"], other: Bool[np.ndarray, "rows columns"]
) -> float:
    """Pixels in both masks over pixels in either [1]; 1 where both are empty."""
    either = int((one | other).sum())
    return int((one & other).sum()) / either if either else 1.0


def mask_of(frames: Frames, *, where: str = "frames") -> Bool[np.ndarray, "rows columns"]:
    """Which pixels show the object, by a threshold between it and what stands behind it.

    The frames are averaged, single pixels smoothed by a median of 3 x 3, and the threshold is the
    one that leaves the least variance within the two parts [K2]. Of the two, the background is the
    one that makes up more of the picture's edge; of the rest the largest connected piece is kept.

    Where more than half of the picture's edge holds NaN in all frames, as in rendered ones, all
    pixels that do are the background, and no temperature is looked at.

    Arguments: `frames`, few enough that the object stands still in them, at a time when it is
    warmer or colder than all that is behind it.

    Raises `InputError` where the two parts are less than four deviations apart: the picture then
    holds no two temperatures; where there are fewer than 16 pixels with a value.

    Source: Otsu, IEEE Trans. Systems, Man and Cybernetics 9 (1979) 62.
    """
    count = frames.valid.sum(axis=0)
    values = np.where(frames.valid, frames.values, 0.0).sum(axis=0, dtype=float)
    known = count > 0
    if known.sum() < 16:
        raise InputError(
            "the frames are all but empty", where=where, value=f"{int(known.sum())} pixels",
            limit="16 pixels with a value", remedy="look at `valid`, or take other frames",
        )  # fmt: skip
    empty = np.asarray(np.isnan(frames.values).all(axis=0))
    if _border(empty).mean() > 0.5:
        return _largest(np.logical_not(empty))
    image = values / np.maximum(count, 1)
    image = ndimage.median_filter(np.where(known, image, np.median(image[known])), size=3)
    level, apart = _threshold(image[known])
    if not apart > _APART:
        raise InputError(
            "object and background cannot be told apart", where=where,
            value=f"the two parts are {apart:.2f} deviations apart",
            limit=f"more than {_APART:g} deviations",
            remedy="take frames in which all of the object is warmer or colder than the room, or, "
            "from Python, draw the mask for align_to_silhouettes",
        )  # fmt: skip
    warm = image > level
    return _largest(known & (warm != (_border(warm).mean() > 0.5)))


def _border(mask: Bool[np.ndarray, "rows columns"]) -> Bool[np.ndarray, " edge"]:
    return np.concatenate([mask[0], mask[-1], mask[1:-1, 0], mask[1:-1, -1]])


def _largest(found: Bool[np.ndarray, "rows columns"]) -> Bool[np.ndarray, "rows columns"]:
    """The largest connected piece."""
    pieces = np.zeros(found.shape, np.int32)
    ndimage.label(found, output=pieces)
    return pieces == 1 + int(np.argmax(np.bincount(pieces.ravel())[1:]))


def _threshold(values: Float[np.ndarray, " pixels"]) -> tuple[float, float]:
    """Otsu's threshold [K], and how far the two means are apart over the deviation within [1]."""
    ordered = np.sort(values)
    below = np.arange(1, len(ordered))
    total = np.cumsum(ordered - ordered.mean())[:-1]
    # Between-class variance; only cuts between different values are thresholds.
    gap = np.diff(ordered) > 0
    if not gap.any():
        return float(ordered[0]), 0.0
    above = len(ordered) - below
    between = np.where(gap, total**2 / (below * above), -np.inf)
    cut = int(np.argmax(between)) + 1
    low, high = ordered[:cut], ordered[cut:]
    within = (low.var() * len(low) + high.var() * len(high)) / len(ordered)
    apart = (high.mean() - low.mean()) / max(np.sqrt(within), np.finfo(np.float32).eps * high[-1])
    return float(ordered[cut - 1] + ordered[cut]) / 2, float(apart)
