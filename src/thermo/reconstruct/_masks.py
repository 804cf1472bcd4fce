"""Which pixels show an object before a dark ground."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

from thermo.errors import InputError
from thermo.observe import check_number

from ._photograph import Photograph

_LEVELS: Final = 256
"""Thresholds that are tried, evenly from 0 to 1 [1]."""
_APART: Final = 2
"""Distance of the two pixels between which a picture is asked how much it changes [px].

A lens and the median below spread an edge over about as much.
"""
_LEAST: Final = 0.01
"""Share of its picture that an object must cover [1], for thresholds to be told apart by it."""
_NOISE: Final = 0.001
"""Holes of less than this share of the object are closed [1]: dark spots, no openings."""


def threshold_of(photographs: Sequence[Photograph]) -> float:
    """The brightness that best tells the object from a dark ground, for all photographs alike [1].

    Of all levels t the one across which brightness changes most: the greatest mean of |v_i - v_j|
    over all pairs of near pixels of which one is brighter than t and the other is not. Just above
    the ground those pairs lie on the object's outline, with the whole step from ground to object;
    at lower levels noise of the ground joins them, at higher ones the object's own shading.

    Raises `InputError` where nothing stands out, and where most of the pictures' edge is brighter
    than that level, so that the ground is not dark.

    Source: after Kohler, Computer Graphics and Image Processing 15 (1981) 319, who takes the lesser
    of both steps from the level; pairs of all photographs count as those of one.
    """
    counts, steps = np.zeros(_LEVELS), np.zeros(_LEVELS)
    least = 0.0
    edges = []
    for one in photographs:
        values = brightness(one.colour)
        least += 4.0 * np.sqrt(_LEAST * values.size)
        edges.append(np.concatenate([values[0], values[-1], values[1:-1, 0], values[1:-1, -1]]))
        for pair in _pairs(values):
            _add(counts, steps, *pair)
    # The outline of a square of that share: few pairs would be highlights.
    mean = np.where(counts >= least, steps / np.maximum(counts, 1.0), 0.0)
    found = (int(np.argmax(mean)) + 0.5) / _LEVELS
    bright = float(np.mean(np.concatenate(edges) > found)) if edges else 1.0
    if not mean.any() or bright > 0.5:
        raise InputError(
            "no dark ground is found behind the object", where="photographs",
            value=f"{bright:.0%} of the pictures' edge is brighter than {found:.3f}, where "
            "brightness changes most",
            limit="an object that is brighter than all behind it, in the middle of the picture",
            remedy="give masks: a folder of them, or pictures with an alpha channel",
        )  # fmt: skip
    return found


def masked_by_threshold(
    photographs: Sequence[Photograph], threshold: float, *, bridged: int = 0
) -> tuple[Photograph, ...]:
    """The photographs with masks of what is brighter than `threshold` [1], 0 to 1.

    Shadows that an object casts on itself are as dark as the ground. Masks are grown by `bridged`
    [px] and shrunk by as much: gaps of up to twice that are closed, shadows and openings alike. A
    body's silhouette is in one piece: of all pieces the largest is kept. Dark spots in it of less
    than a thousandth of its size are closed; larger ones may be openings.

    Raises `InputError` for a threshold outside 0 to 1 and for a negative `bridged`.

    Source: the description of the Middlebury data, which grows masks by 10 and shrinks them by 7
    pixels (Seitz et al., CVPR 2006).
    """
    check_number(
        bridged, where="bridged", quantity="half the width of gaps to close [px]", least=0.0,
        remedy="give pixels, 0 to close no gaps",
    )  # fmt: skip
    check_number(
        threshold, where="threshold", quantity="brightness of the object [1]", above=0.0, most=1.0,
        remedy="give a brightness between that of the ground and that of the object",
    )  # fmt: skip
    return tuple(
        Photograph(
            one.camera, one.colour, _mask(brightness(one.colour), threshold, bridged), one.file
        )
        for one in photographs
    )


def brightness(colour: Float[np.ndarray, "rows columns 3"]) -> Float[np.ndarray, "rows columns"]:
    """The brightest of the three channels [1], single pixels smoothed by a median of 3 x 3.

    A saturated colour is as far from black as a white one.
    """
    return np.asarray(ndimage.median_filter(colour.max(axis=2), size=3))


def _mask(
    values: Float[np.ndarray, "rows columns"], threshold: float, bridged: float
) -> Float[np.ndarray, "rows columns"]:
    bright = _bridged(values > threshold, bridged)
    pieces, count = _pieces(bright)
    if not count:
        return np.zeros(values.shape)
    sizes = np.bincount(pieces.ravel())
    sizes[0] = 0
    kept = pieces == np.argmax(sizes)
    holes, _ = _pieces(np.logical_not(kept))
    small = np.bincount(holes.ravel()) < _NOISE * sizes.max()
    return np.where(small[holes], 1.0, kept.astype(float))


def _bridged(
    bright: Bool[np.ndarray, "rows columns"], reach: float
) -> Bool[np.ndarray, "rows columns"]:
    """Grown by `reach` [px] all round and shrunk by as much; the picture's edge stops neither."""
    if not reach or not bright.any():
        return bright
    wide = int(np.ceil(reach)) + 1
    padded = np.pad(bright, wide)
    grown = np.asarray(ndimage.distance_transform_edt(~padded)) <= reach
    shrunk = np.asarray(ndimage.distance_transform_edt(grown)) > reach
    return shrunk[wide:-wide, wide:-wide] | bright


def _pieces(found: Bool[np.ndarray, "rows columns"]) -> tuple[np.ndarray, int]:
    pieces = np.zeros(found.shape, np.int32)
    ndimage.label(found, output=pieces)
    return pieces, int(pieces.max(initial=0))


def _pairs(values: Float[np.ndarray, "rows columns"]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Darker and brighter values of pixels below and beside each other."""
    both = [(values[_APART:], values[:-_APART]), (values[:, _APART:], values[:, :-_APART])]
    return [(np.minimum(a, b).ravel(), np.maximum(a, b).ravel()) for a, b in both]


def _add(counts: np.ndarray, steps: np.ndarray, low: np.ndarray, high: np.ndarray) -> None:
    """Add pairs to all levels between their values."""
    first = np.ceil(low * _LEVELS - 0.5).astype(int)
    past = np.floor(high * _LEVELS - 0.5).astype(int) + 1
    between = past > first
    first, past, step = first[between], past[between], (high - low)[between]
    for total, weight in ((counts, None), (steps, step)):
        begun = np.bincount(first, weight, _LEVELS + 1)
        ended = np.bincount(past, weight, _LEVELS + 1)
        total += np.cumsum(begun - ended)[:_LEVELS]
