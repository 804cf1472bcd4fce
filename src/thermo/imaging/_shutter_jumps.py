"""Jumps of a whole image, as when a camera's shutter recalibrates it."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import stats

_ALARM: Final = 0.01
"""Chance that any jump is told of in a clean recording [1]."""

_LEAST: Final = 6
"""Frames below which nothing tells a jump from a course [1]."""

_EFFICIENCY: Final = 0.37
"""Share of normal observations that a median absolute deviation makes use of [1]: its efficiency,
Rousseeuw and Croux, J. Am. Stat. Assoc. 88 (1993) 1273."""

_QUARTER: Final = 0.25
_TAILS: Final = (0.05, 0.95)
_CALM: Final = 9
"""Steps that a jump's spread over the image is compared with [1]."""

Images = Float[np.ndarray, "frames rows columns"]
Valid = Bool[np.ndarray, "frames rows columns"]


def shutter_jumps(
    time: Float[np.ndarray, " frames"], values: Images, valid: Valid
) -> tuple[Int[np.ndarray, " jumps"], Float[np.ndarray, " jumps"]]:
    """First frames after a jump, and how far each went [K] or [1].

    Arguments: times [s], values [K] or [1] and what is valid, without duplicates.

    With D_t the change to the next frame that the middle half of the pixels has on average, and
    e_t what D_t differs from the mean of the changes before and after it, in proportion to time, a
    jump is a change that

    - stands out beyond the change before and beyond the one after, which a lamp that is switched
      on does not: the course of D_t then has a step and no spike;
    - by more than Student's quantile for the number of steps times 1.4826 MAD(e); and
    - is the same everywhere: nine of ten pixels, less their usual noise, moved by half as much to
      one and a half times as much. A flash that heats an object and not what is behind it fails
      here.
    """
    none = np.zeros(0, int), np.zeros(0)
    if len(time) < _LEAST:
        return none
    change = np.array([_middle_half(values, valid, t) for t in range(len(time) - 1)])
    step = np.diff(time)
    before = change[1:-1] - change[:-2] / step[:-2] * step[1:-1]
    after = change[1:-1] - change[2:] / step[2:] * step[1:-1]
    differs = 0.5 * (before + after)
    known = np.isfinite(differs)
    count = int(known.sum())
    if count < _LEAST - 2:
        return none
    deviation = np.median(np.abs(differs[known] - np.median(differs[known])))
    # The median absolute deviation of few values is low, by 0.8 / n of it: Croux and Rousseeuw,
    # Computational Statistics 1 (1992) 411.
    scale = 1.4826 * deviation * count / (count - 0.8)
    limit = stats.t.isf(_ALARM / (2.0 * count), _EFFICIENCY * count) * scale
    sticks = np.where(before * after > 0, np.minimum(np.abs(before), np.abs(after)), 0.0)
    candidates = 1 + np.flatnonzero(known & (sticks > limit))
    calm = np.setdiff1d(1 + np.flatnonzero(known), candidates)
    usual = _usual(time, values, valid, calm)
    found = [
        t
        for t in candidates.tolist()
        if _uniform(_spread(time, values, valid, t), usual, differs[t - 1])
    ]
    return np.array(found, int) + 1, differs[np.array(found, int) - 1]


def _middle_half(values: np.ndarray, valid: np.ndarray, t: int) -> float:
    use = valid[t] & valid[t + 1]
    change = values[t + 1][use].astype(np.float64) - values[t][use]
    return float(stats.trim_mean(change, _QUARTER)) if change.size else float("nan")


def _spread(time: np.ndarray, values: np.ndarray, valid: np.ndarray, t: int) -> np.ndarray:
    """Tails over the image of the change at step `t`, less those before and after it."""
    use = valid[t - 1 : t + 3].all(axis=0)
    if not use.any():
        return np.full(len(_TAILS), np.nan)
    frames = values[t - 1 : t + 3, use].astype(np.float64)
    rates = np.diff(frames, axis=0) / np.diff(time[t - 1 : t + 3])[:, None]
    return np.quantile((rates[1] - 0.5 * (rates[0] + rates[2])) * (time[t + 1] - time[t]), _TAILS)


def _usual(time: np.ndarray, values: np.ndarray, valid: np.ndarray, calm: np.ndarray) -> np.ndarray:
    if not calm.size:
        return np.full(len(_TAILS), np.nan)
    picked = calm[np.unique(np.linspace(0, len(calm) - 1, _CALM).astype(int))]
    return np.median([_spread(time, values, valid, t) for t in picked.tolist()], axis=0)


def _uniform(tails: np.ndarray, usual: np.ndarray, jump: float) -> bool:
    return bool((np.abs(tails - usual - jump) <= 0.5 * abs(jump)).all())
