"""Pixels that do not measure: frozen ones, stuck ones and those that flicker."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Bool, Float, Shaped
from scipy import ndimage, stats

_ALARM: Final = 0.01
"""Chance that any pixel of a clean recording is called dead [1]; a third for each way to be so."""

_BLUNT: Final = 1.4826
"""From the median absolute deviation to the standard deviation of a normal law [1]."""

_RING: Final = np.ones((5, 5), bool)
_RING[2, 2] = False
_SPARE: Final = 3
"""Pixels of the 24 about one that may be dead themselves [1]: pairs and 2 x 2 blocks are seen."""


def dead_pixels(
    values: Float[np.ndarray, "frames rows columns"],
    valid: Bool[np.ndarray, "frames rows columns"],
) -> Bool[np.ndarray, "rows columns"]:
    """Which pixels do not measure, of frames [K] or [1] without duplicates.

    A pixel is dead if, with limits corrected for the number of pixels (Bonferroni),

    - it never changes, though a sensor with the noise about it would stay within one step of its
      numbers through n frames only with the chance (2 Phi(q / 2 sigma) - 1)^(n - 1), q that step;
    - it is off: in both halves of the recording its mean lies outside those of the 24 about it, by
      more than they differ among themselves and by more than noise; or
    - it flickers: in both halves the variance of v(t-1) - 2 v(t) + v(t+1), less what is common to
      all, over triples that do not overlap, which follows chi2, lies outside in the same way.

    Outside means: beyond all but three of the 24. So the edge or corner of an object is not dead,
    and neither is a spot that is hot and as wide as a lens can make it.
    """
    rows, columns = valid.shape[1:]
    seen = valid.any(axis=0)
    if not seen.any() or min(rows, columns) < 3:
        return np.zeros((rows, columns), bool)
    level = _ALARM / 3 / int(seen.sum())
    half = len(values) // 2
    parts = [slice(0, half), slice(half, None)] if half else [slice(None)]
    bends = [_triples(values[part], valid[part]) for part in parts]
    plain, count = sum(one[0] for one in bends), sum(one[2] for one in bends)
    dead = _frozen(values, valid, np.asarray(plain), np.asarray(count), level)
    dead |= np.logical_and.reduce([_flickering(one[1], one[2], level) for one in bends])
    dead |= np.logical_and.reduce([_off(values[part], valid[part], level) for part in parts])
    return dead & seen


def _triples(
    values: Shaped[np.ndarray, "frames rows columns"],
    valid: Bool[np.ndarray, "frames rows columns"],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sums of squares over triples, as they are and without what all share; and their number."""
    plain, common = np.zeros(valid.shape[1:]), np.zeros(valid.shape[1:])
    count = np.zeros(valid.shape[1:], int)
    for first in range(0, len(values) - 2, 3):
        one, two, three = (values[first + k].astype(np.float64) for k in range(3))
        use = valid[first : first + 3].all(axis=0)
        if not use.any():
            continue
        bend = np.where(use, (one - 2.0 * two + three) / np.sqrt(6.0), 0.0)
        plain += bend**2
        common += np.where(use, bend - np.median(bend[use]), 0.0) ** 2
        count += use
    return plain, common, count


def _frozen(
    values: np.ndarray, valid: np.ndarray, squares: np.ndarray, count: np.ndarray, level: float
) -> np.ndarray:
    highest, lowest = np.full(valid.shape[1:], -np.inf), np.full(valid.shape[1:], np.inf)
    for image, use in zip(values, valid, strict=True):
        np.maximum(highest, image, out=highest, where=use)
        np.minimum(lowest, image, out=lowest, where=use)
    still = highest == lowest
    if not still.any() or not (count > 0).any():
        return np.zeros_like(still)
    step = _step(values, valid)
    noise = np.where(count > 0, squares / np.maximum(count, 1), np.nan)
    # Rounding to steps adds at most step^2 / 12 to the variance: what is left is a lower bound.
    left = _middle(_filled(noise)) - step**2 / 12.0
    with np.errstate(divide="ignore"):
        reach = step / (2.0 * np.sqrt(np.maximum(left, 0.0)))
    stay = 2.0 * stats.norm.cdf(reach) - 1.0
    return still & (stay ** np.maximum(valid.sum(axis=0) - 1, 0) < level)


def _step(values: np.ndarray, valid: np.ndarray) -> float:
    """The smallest difference between a pixel's frames [K] or [1]; 0 if nothing changes."""
    least = np.inf
    for index in range(len(values) - 1):
        use = valid[index] & valid[index + 1]
        change = np.abs(values[index + 1][use].astype(np.float64) - values[index][use])
        least = min(least, np.min(change, where=change > 0, initial=np.inf))
    return float(least) if np.isfinite(least) else 0.0


def _flickering(squares: np.ndarray, count: np.ndarray, level: float) -> np.ndarray:
    known = count > 0
    if not known.any():
        return np.zeros_like(known)
    # The median of chi2 / m, so that dead pixels do not shift what a living one's noise is.
    part = np.where(known, squares / np.maximum(count, 1), np.nan)
    typical = stats.chi2.median(np.maximum(count, 1)) / np.maximum(count, 1)
    scale = float(np.median(part[known] / typical[known]))
    if scale == 0.0:
        return np.zeros_like(known)
    # Shares below the smallest number there is lie beyond 38 deviations.
    share = stats.chi2.sf(np.where(known, squares, 0.0) / scale, np.maximum(count, 1))
    score = np.where(known, np.clip(stats.norm.isf(share), -38.0, 38.0), np.nan)
    # Where noise differs over the image more than chi2 says, scores spread more than one.
    spread = max(1.0, _BLUNT * float(np.nanmedian(np.abs(score - np.nanmedian(score)))))
    filled = _filled(score / spread)
    high, _, width = _ring(filled)
    return known & (filled - high > np.maximum(width, stats.norm.isf(level)))


def _off(values: np.ndarray, valid: np.ndarray, level: float) -> np.ndarray:
    total, count = np.zeros(valid.shape[1:]), valid.sum(axis=0)
    for image, use in zip(values, valid, strict=True):
        total += np.where(use, image, 0.0)
    if not count.any():
        return np.zeros(valid.shape[1:], bool)
    mean = _filled(np.where(count > 0, total / np.maximum(count, 1), np.nan))
    high, low, width = _ring(mean)
    away = mean - _middle(mean)
    noise = _BLUNT * float(np.median(np.abs(away[count > 0])))
    beyond = np.maximum(mean - high, low - mean)
    return (count > 0) & (beyond > np.maximum(width, stats.norm.isf(level / 2.0) * noise))


def _ring(image: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Highest and lowest of the 24 about each pixel but three, and how far they are apart."""
    high = ndimage.rank_filter(image, -1 - _SPARE, footprint=_RING, mode="mirror")
    low = ndimage.rank_filter(image, _SPARE, footprint=_RING, mode="mirror")
    return high, low, high - low


def _middle(image: np.ndarray) -> np.ndarray:
    return ndimage.median_filter(image, footprint=_RING, mode="mirror")


def _filled(image: np.ndarray) -> np.ndarray:
    """An image whose missing pixels hold what the nearest known one does."""
    missing = np.isnan(image)
    if not missing.any():
        return image
    nearest = ndimage.distance_transform_edt(missing, return_distances=False, return_indices=True)
    return image[tuple(np.asarray(nearest))]
