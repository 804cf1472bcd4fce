"""Whether recordings fit the cameras and the surface they are said to be of, by silhouettes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import ndimage
from scipy.optimize import linear_sum_assignment

from thermo.errors import InputError

from ._frames import Frames
from ._looks import Looks
from ._silhouette import mask_of

_CLEAR: Final = 2.0
"""How many times closer another recording must fit [1]; see `better_order`."""

_RESOLVED: Final = 1.0
"""How much closer it must fit besides [px]: masks of pixels show no smaller shift."""


def better_order(looks: Looks, frames: Sequence[Frames]) -> tuple[int, ...] | None:
    """Which recording each camera would have, where another order fits clearly better; or None.

    `mask_of` finds the object in each recording. Let d_ij be the number of pixels in which the
    mask of recording j and the silhouette that camera i has of the surface differ, over the pixels
    along that silhouette: about how far apart the two contours lie [px]. Of all orders the one of
    the least sum of d is taken, and of its cycles those in which every camera has
    d_ij < d_ii / 2 and d_ij < d_ii - 1 px.

    A surface a little out of place is no such cycle: where the order is right, what poses and masks
    are off by makes all d_ii. In two cameras i and j it would have to bring the object of each to
    where the other's is expected, to within half of the way, at once. Masks of less than the whole
    object make none either: where the mask of each lies within both silhouettes, the sum over the
    two is the same in either order.

    None is returned as well where a recording does not show the object apart from the room.

    Arguments: `looks` of `looks_of`; `frames`, temperatures [K], a recording a camera.
    """
    apart = _of_all(looks, frames)
    if apart is None:
        return None
    _, order = linear_sum_assignment(apart)
    own, other = np.diag(apart), apart[np.arange(len(order)), order]
    clear = (other < own / _CLEAR) & (other < own - _RESOLVED)
    kept = np.arange(len(order))
    for cycle in _cycles(order):
        if clear[cycle].all():
            kept[cycle] = order[cycle]
    return tuple(kept.tolist()) if (kept != np.arange(len(order))).any() else None


def contours_apart(looks: Looks, frames: Sequence[Frames]) -> Float[np.ndarray, " cameras"] | None:
    """About how far the object's contour in each recording lies from the surface's [px]; or None.

    d_ii of `better_order`: what poses, the surface's place and the masks are off by. It means
    little where a mask is not of the whole object. None where a recording does not show the object
    apart from the room.

    Arguments: `looks` of `looks_of`; `frames`, temperatures [K], a recording a camera.
    """
    apart = _of_all(looks, frames)
    return None if apart is None else np.diag(apart)


def _of_all(
    looks: Looks, frames: Sequence[Frames]
) -> Float[np.ndarray, "cameras recordings"] | None:
    try:
        masks = [mask_of(one) for one in frames]
    except InputError:
        return None
    return _apart([one.triangle >= 0 for one in looks.maps], masks)


def _apart(
    expected: Sequence[Bool[np.ndarray, "_ _"]], found: Sequence[Bool[np.ndarray, "_ _"]]
) -> Float[np.ndarray, "cameras recordings"]:
    """How far contours lie apart [px]; infinite where frames are of another size."""
    apart = np.full((len(expected), len(found)), np.inf)
    for camera, silhouette in enumerate(expected):
        inner = ndimage.binary_erosion(silhouette, border_value=True)
        along = max(int((silhouette & np.logical_not(inner)).sum()), 1)
        for recording, mask in enumerate(found):
            if mask.shape == silhouette.shape:
                apart[camera, recording] = (mask ^ silhouette).sum() / along
    return apart


def _cycles(order: Int[np.ndarray, " cameras"]) -> list[list[int]]:
    """The cycles of a permutation that move something."""
    left, cycles = set(range(len(order))), []
    while left:
        cycle = [min(left)]
        while (onward := int(order[cycle[-1]])) != cycle[0]:
            cycle.append(onward)
        left -= set(cycle)
        cycles += [cycle] if len(cycle) > 1 else []
    return cycles
