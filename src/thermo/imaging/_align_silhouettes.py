"""The pose of an object whose silhouettes meet the masks of cameras."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage
from scipy.spatial import KDTree

from thermo.errors import InputError
from thermo.mesh import Surface
from thermo.observe import check_number

from ._align_descend import Descent, Matched, descend
from ._align_rim import Outline, Rim, Sight, outline, rim_of, sight_of
from ._align_untold import inflation, knowledge
from ._camera import Camera
from ._silhouette import overlap
from ._similarity import Similarity

_SMOOTH: Final = 0.4
"""Deviation of the smoothing of distances to a mask's contour, which runs in steps [px]; more of
it draws round contours inward, by its square over twice their radius."""

_ENOUGH: Final = 0.002
"""A root mean square change of the contour that ends the descent [px]."""

_FLOOR: Final = 0.15
"""What the contour of a mask of whole pixels is off by at least [px]."""

_NEAR: Final = 0.75
"""Pixels whose centres lie this near to a mask's contour tell where it runs [px]."""

_ALIKE: Final = 6.0
"""Residuals this near each other on the contour may be alike [px]."""


@final
class Alignment(eqx.Module):
    """An object brought to where cameras see it.

    Arguments:

    - `similarity`: brings the surface from its own axes to the world.
    - `residual`: root mean square distance of the silhouettes' contours from the masks' [px].
    - `overlap_before`, `overlap_after`: pixels in both mask and silhouette over pixels in either,
      (views,) [1].
    - `deviation`: one standard deviation of the rotation vector [rad], of the shift of the
      object's centre [m] and of the logarithm of the scale [1], (7,), along the world's axes.
      Motions that are not told count with the size of the object.
    - `untold`: motions that the masks do not tell, in words.
    - `success`: whether the descent converged to a fit as good as the masks' contours allow.
    - `reason`: in words.
    """

    similarity: Similarity
    residual: float
    overlap_before: Float[np.ndarray, " views"]
    overlap_after: Float[np.ndarray, " views"]
    deviation: Float[np.ndarray, "7"]
    untold: tuple[str, ...] = eqx.field(static=True)
    success: bool = eqx.field(static=True)
    reason: str = eqx.field(static=True)


@final
class _View(eqx.Module):
    """A camera with its mask, the signed distance to the contour [px] and points on it [px]."""

    sight: Sight
    mask: Bool[np.ndarray, "rows columns"]
    distance: Float[np.ndarray, "rows columns"]
    contour: Float[np.ndarray, "contour 2"]
    tree: KDTree


def align_to_silhouettes(
    surface: Surface,
    cameras: Sequence[Camera],
    masks: Sequence[Bool[np.ndarray, "_rows _columns"]],
    guess: Similarity | None = None,
    *,
    scale: bool = False,
    contour_error: float = 1.0,
) -> Alignment:
    """Turn, shift and, where asked for, scale a surface until its silhouettes meet masks.

    Residuals are the distances of the points of the silhouettes' rims from the masks' contours and
    back, [px], outward positive. Damped Gauss-Newton steps lessen them under Tukey's loss, with the
    rims found anew after each one. A rim moves with the normal motion of its points, so that this
    is the whole slope. The start must be near: contours some ten pixels apart at the most.

    Arguments:

    - `surface`: in its own axes [m], closed and turned outward.
    - `cameras`, `masks`: one mask (rows, columns) a camera, true where the object is seen.
    - `guess`: brings the surface to about where it is; as it stands where it is left out.
    - `scale`: whether the scale is free too.
    - `contour_error`: one standard deviation of the masks' contours [px]; a fit that leaves half
      as much more, or masks that overlap less than such contours do, is reported as failed.

    Raises `InputError` for masks that do not fit their cameras, show nothing or all, and for
    objects that a camera with a mask does not see at the start.

    Source: iterated closest contour points, Fitzgibbon, Image and Vision Computing 21 (2003) 1145;
    distance transforms, Maurer et al., IEEE Trans. Pattern Analysis 25 (2003) 265.
    """
    error = check_number(
        contour_error, where="contour_error", quantity="error of contours [px]", above=0.0
    )
    _check(cameras, masks)
    start = Similarity() if guess is None else guess
    body = outline(surface)
    views = [_view(camera, mask) for camera, mask in zip(cameras, masks, strict=True)]
    before = _overlaps(body, views, start)
    middle, size = centre_and_size(surface)

    def match(pose: Similarity) -> Matched:
        return _matched(views, [rim_of(body, view.sight, pose) for view in views])

    found = descend(match, start, middle, size, scale=scale, enough=_ENOUGH)
    rims = [rim_of(body, view.sight, found.similarity) for view in views]
    after = np.array([overlap(v.mask, r.mask) for v, r in zip(views, rims, strict=True)])
    alike = _inflation(views, rims, found.matched, 6 + scale)
    there = found.similarity.apply(middle[None])[0]
    apart = float(np.mean([np.linalg.norm(v.sight.place - there) for v in views]))
    told = knowledge(match, found, middle, size, scale=scale, inflation=alike, apart=apart)
    residual = float(np.sqrt(np.mean(found.matched.residual**2)))
    reason = _failure(views, found, after, residual, error)
    return Alignment(
        found.similarity, residual, before, after, told.deviation, told.untold,
        not reason, reason or f"converged in {found.steps} steps",
    )  # fmt: skip


def centre_and_size(surface: Surface) -> tuple[Float[np.ndarray, "3"], float]:
    """Centre of a surface's box [m], and the root mean square distance of its vertices from it."""
    middle = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
    return middle, float(np.sqrt(((surface.vertices - middle) ** 2).sum(axis=1).mean()))


def _check(cameras: Sequence[Camera], masks: Sequence[Bool[np.ndarray, "_rows _columns"]]) -> None:
    if len(cameras) != len(masks) or not cameras:
        raise InputError(
            "cameras and masks differ in number", where="masks",
            value=f"{len(cameras)} cameras, {len(masks)} masks",
            limit="one mask a camera, at least one", remedy="leave out cameras without a mask",
        )  # fmt: skip
    for camera, mask in zip(cameras, masks, strict=True):
        if mask.shape != (camera.height, camera.width):
            raise InputError(
                "a mask does not fit its camera", where=camera.name, value=f"shape {mask.shape}",
                limit=f"shape ({camera.height}, {camera.width}), rows first",
                remedy="look at the order of the masks and for one that is transposed",
            )  # fmt: skip
        if mask.all() or not mask.any():
            raise InputError(
                "a mask shows no contour", where=camera.name,
                value=f"{int(mask.sum())} of {mask.size} pixels", limit="a part of the pixels",
                remedy="leave out this camera, or look at how its mask was made",
            )  # fmt: skip


def _view(camera: Camera, mask: Bool[np.ndarray, "rows columns"]) -> _View:
    outside = np.asarray(ndimage.distance_transform_edt(~mask))
    inside = np.asarray(ndimage.distance_transform_edt(mask))
    # The contour runs half a pixel from the centres on both of its sides.
    distance = np.where(mask, 0.5 - inside, outside - 0.5)
    distance = ndimage.gaussian_filter(distance, _SMOOTH, mode="nearest")
    downward, rightward = np.gradient(distance)
    slope = np.stack([rightward, downward], axis=-1)
    rows, columns = np.nonzero(np.abs(distance) < _NEAR)
    direction, level = slope[rows, columns], distance[rows, columns][:, None]
    length = np.maximum((direction**2).sum(axis=1, keepdims=True), 0.25)
    contour = np.stack([columns, rows], axis=1) - level * direction / length
    return _View(sight_of(camera), mask, distance, contour, KDTree(contour))


def _overlaps(body: Outline, views: Sequence[_View], pose: Similarity) -> np.ndarray:
    found = []
    for view in views:
        rim = rim_of(body, view.sight, pose)
        if not rim.mask.any() or len(rim.points) == 0:
            raise InputError(
                "the object is out of view", where=view.sight.camera.name,
                value=f"silhouette of {int(rim.mask.sum())} pixels, mask of "
                f"{int(view.mask.sum())}",
                limit="an object of which this camera sees the rim",
                remedy="give a nearer guess, check the camera's pose and unit, or leave it out",
            )  # fmt: skip
        found.append(overlap(view.mask, rim.mask))
    return np.array(found)


def _matched(views: Sequence[_View], rims: Sequence[Rim]) -> Matched:
    """Distances from rims to masks and back."""
    residual, points, slope = [], [], []
    for view, rim in zip(views, rims, strict=True):
        if len(rim.points) == 0:
            # Moved out of view: all of the mask's contour is far from everything.
            far = np.full(len(view.contour), float(np.hypot(*view.mask.shape)))
            residual.append(far)
            points.append(np.zeros((len(far), 3)))
            slope.append(np.zeros((len(far), 3)))
            continue
        residual.append(_off(view, rim))
        _, close = KDTree(rim.pixels).query(view.contour)
        apart = rim.pixels[close] - view.contour
        residual.append(np.einsum("ij,ij->i", apart, rim.outward[close]))
        points += [rim.points, rim.points[close]]
        slope += [rim.slope, rim.slope[close]]
    return Matched(np.concatenate(residual), np.concatenate(points), np.concatenate(slope), _FLOOR)


def _off(view: _View, rim: Rim) -> Float[np.ndarray, " rim"]:
    """How far the rim's points lie outside of the mask [px]."""
    return ndimage.map_coordinates(view.distance, rim.pixels[:, ::-1].T, order=1, mode="nearest")


def _inflation(views: Sequence[_View], rims: Sequence[Rim], matched: Matched, free: int) -> float:
    """How many residuals tell as much as one independent one [1].

    Residuals of rim and mask tell of one piece of a contour twice.
    """
    places = [np.concatenate([r.pixels, v.contour]) for v, r in zip(views, rims, strict=True)]
    ends = np.cumsum([len(one) for one in places])[:-1]
    weighted = np.split(matched.weights() * matched.residual, ends)
    return inflation(zip(places, weighted, strict=True), _ALIKE, free)


def _failure(
    views: Sequence[_View],
    found: Descent,
    after: Float[np.ndarray, " views"],
    residual: float,
    error: float,
) -> str:
    """Why the fit is not to be believed, or nothing.

    Contours off by e [px] along a perimeter of p pixels leave p E|e| of a mask's pixels apart,
    E|e| = 0.8 e for normal errors; half as much more is allowed.
    """
    if not found.converged:
        return f"no convergence in {found.steps} steps"
    noise = min(max(found.matched.spread(), 0.25), error)
    for view, have in zip(views, after, strict=True):
        # Pixels as near as that to the contour are one and a half times its length.
        least = 1.0 - 1.2 * noise * len(view.contour) / (2 * _NEAR) / float(view.mask.sum())
        if have < least:
            return f"overlap of {have:.3f} in {view.sight.camera.name}, less than {least:.3f}"
    if residual > 1.5 * error:
        return f"contours {residual:.2f} px apart, over one and a half times {error:g} px"
    return ""
