"""How noisy a recording is, from its quiet frames or from the record itself."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
from jaxtyping import Float, Int
from scipy.stats import chi2

from ._recording import Recording

FLOOR: Final = 3e-5
"""Records are stored in single precision, whose spacing near 300 K this is [K]. It also keeps the
weights of noise-free data finite."""

LEAST_FRAMES: Final = 8
"""Quiet frames [1] below which nothing is said of what frames have in common."""

LEAST_SAMPLES: Final = 8
"""Samples [1] below which nothing is said of it."""

_CHANCE: Final = 1e-4
"""Share of recordings without a common error in which one is seen [1]."""

# Two readings that differ by less than this are the same number, stored in two ways [K].
_SAME: Final = 1e-7
# A coarser grid than this is not the rounding of a thermometer [K].
_COARSEST: Final = 1.0


@final
@dataclass(frozen=True)
class Noise:
    """Standard deviations of a recording's noise [K].

    Arguments:

    - `white`: of one reading around its sample's mean, fluctuating from frame to frame [K].
    - `offset`: of the samples' constant errors around their common mean [K].
    - `correlation`: of one frame's fluctuation with the next frame's (1).
    - `frame`: of what all samples of a frame have in common, each frame by itself [K].
    """

    white: float
    offset: float
    correlation: float = 0.0
    frame: float = 0.0

    def long_run(self) -> float:
        """What the fluctuation weighs in a mean of many frames, white sqrt((1 + r)/(1 - r)) [K]."""
        return float(self.white * np.sqrt((1 + self.correlation) / (1 - self.correlation)))

    def mean_variance(self, count: Int[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
        """Variance of the fluctuation in a mean of `count` [1] frames, many of them [K2]."""
        return np.minimum(self.long_run() ** 2 / count, self.white**2)

    def fluctuation(self) -> float:
        """Of a reading around its sample's mean, sqrt(white^2 + frame^2) [K]."""
        return float(np.hypot(self.white, self.frame))

    def total(self) -> float:
        """Return the standard deviation of a reading, sqrt(white^2 + frame^2 + offset^2) [K]."""
        return float(np.hypot(self.fluctuation(), self.offset))


def estimate_noise(recording: Recording) -> Noise:
    """Estimate the noise of a recording [K].

    With at least three quiet frames the fluctuation is taken as first-order autoregressive with
    standard deviation s and correlation r from frame to frame. The mean squares of the
    differences over one and over two frames are then d1 = 2 s^2 (1 - r) and
    d2 = 2 s^2 (1 - r^2), so r = d2/d1 - 1 and s^2 = d1 / (2 (1 - r)). The offset is the standard
    deviation of the samples' means, less what the fluctuation itself adds to it.

    With eight quiet frames of eight samples or more, `frame` is what frames' means fluctuate by
    beyond what the samples' own fluctuation makes of them, in all but a few recordings of ten
    thousand; what the samples do is then that about their frame's mean. It is zero otherwise.

    Without quiet frames the fluctuation comes from second differences of the record, through
    their median absolute value, so that a switching lamp does not count. It is then taken as
    uncorrelated, and the offset as 0, since neither can be told from the object's own warming.

    The white part is never below the rounding of the data, step / sqrt(12), nor
    below the spacing of single precision, 3e-5 K.
    """
    quiet = recording.quiet
    if quiet is not None and recording.knows_quiet():
        found = _from_quiet(quiet)
    else:
        found = Noise(_from_record(recording), 0.0)
    floor = max(rounding(recording) / math.sqrt(12.0), FLOOR)
    return replace(found, white=max(found.white, floor))


def variance_error(recording: Recording) -> float:
    """Standard deviation of the variance that `estimate_noise` tells, over that variance [1].

    Of n readings, sqrt(3 / n (1 + r^2) / (1 - r^2)) / (1 - r) by mean squares of differences, which
    tell r of `Noise` as well; by their median, which holds against a switching lamp, sqrt(8 / n).

    Source: von Neumann, Ann. Math. Statist. 12 (1941) 367, successive differences; Rousseeuw and
    Croux, J. Am. Statist. Ass. 88 (1993) 1273, the median's efficiency of 37 %.
    """
    quiet = recording.quiet
    if quiet is None or not recording.knows_quiet():
        return math.sqrt(8.0 / max(int(recording.valid.sum()), 1))
    kept = estimate_noise(recording).correlation
    count = max(int(np.isfinite(quiet).sum()), 1)
    return math.sqrt(3.0 / count * (1 + kept**2) / (1 - kept**2)) / (1 - kept)


def _from_quiet(quiet: Float[np.ndarray, "quiet samples"]) -> Noise:
    alone = _fluctuation(quiet)
    frame = _frame_error(quiet, alone)
    if frame > 0:
        alone = replace(_fluctuation(without_common(quiet)), frame=frame)
    known = ~np.isnan(quiet)
    count = known.sum(axis=0)
    seen = count > 0
    if seen.sum() < 2:
        return alone
    mean = np.where(known, quiet, 0.0).sum(axis=0)[seen] / count[seen]
    own = float(np.mean(alone.mean_variance(count[seen])))
    offset = float(np.sqrt(max(float(np.var(mean, ddof=1)) - own, 0.0)))
    return replace(alone, offset=offset)


def _fluctuation(quiet: Float[np.ndarray, "quiet samples"]) -> Noise:
    one, two = _mean_square(quiet[1:] - quiet[:-1]), _mean_square(quiet[2:] - quiet[:-2])
    # Frames that repeat each other would give r = 1 and no finite variance.
    correlation = float(np.clip(two / one - 1.0, 0.0, 0.95)) if one > 0 else 0.0
    return Noise(float(np.sqrt(one / (2.0 * (1.0 - correlation)))), 0.0, correlation)


def without_common(quiet: Float[np.ndarray, "quiet samples"]) -> Float[np.ndarray, "quiet samples"]:
    """Readings [K] less what all samples of their frame have in common.

    What is left of independent ones is less by the share that each has in the mean, and is made up
    for; NaN where a frame has one reading.
    """
    centred = quiet - _mean(quiet, 0)
    count = np.isfinite(centred).sum(1, keepdims=True)
    # A reading by itself is its frame's mean: nothing is left of it to tell.
    alone = np.where(count > 1, centred - _mean(centred, 1), np.nan)
    return alone * np.sqrt(count / np.maximum(count - 1, 1))


def _mean(values: Float[np.ndarray, "quiet samples"], axis: int) -> np.ndarray:
    """Means of what is known; 0 where nothing is."""
    known = np.isfinite(values)
    total = np.where(known, values, 0.0).sum(axis, keepdims=True)
    return total / np.maximum(known.sum(axis, keepdims=True), 1)


def _frame_error(quiet: Float[np.ndarray, "quiet samples"], alone: Noise) -> float:
    """Deviation of the frames' common error [K], where it is more than chance makes of none.

    `alone`: the fluctuation as it is where frames have nothing in common.
    """
    quiet = quiet[np.isfinite(quiet).any(1)][:, np.isfinite(quiet).any(0)]
    frames, samples = quiet.shape
    if frames < LEAST_FRAMES or samples < LEAST_SAMPLES:
        return 0.0
    common = _mean(quiet - _mean(quiet, 0), 1)[:, 0]
    variance = float(np.mean(np.diff(common) ** 2)) / 2
    # Of samples that have nothing in common; what they have adds to theirs as to the mean's.
    own = (alone.white**2 * (1 - alone.correlation) - variance) / max(samples - 1, 1)
    # Mean squares of n differences scatter as those of 2 n / 3 independent values do.
    degrees = 2 * (frames - 1) / 3
    if variance < own * chi2.isf(_CHANCE, degrees) / degrees:
        return 0.0
    return float(np.sqrt(variance - own))


def _from_record(recording: Recording) -> float:
    time, temperature, valid = recording.time, recording.temperature, recording.valid
    if len(time) < 3:
        return 0.0
    # Distance of a reading from the straight line through its neighbours in time.
    left = ((time[2:] - time[1:-1]) / (time[2:] - time[:-2]))[:, None]
    line = left * temperature[:-2] + (1.0 - left) * temperature[2:]
    scaled = (temperature[1:-1] - line) / np.sqrt(1.0 + left**2 + (1.0 - left) ** 2)
    known = valid[:-2] & valid[1:-1] & valid[2:]
    if not known.any():
        return 0.0
    return 1.4826 * float(np.median(np.abs(scaled[known])))


def _mean_square(difference: np.ndarray) -> float:
    known = ~np.isnan(difference)
    return float(np.sum(difference[known] ** 2) / max(int(known.sum()), 1))


def rounding(recording: Recording) -> float:
    """Return the step to which the data were rounded [K], 0 where it does not show."""
    known = recording.valid[1:] & recording.valid[:-1]
    change = np.abs(np.diff(recording.temperature, axis=0))[known]
    # Only a step that is coarse against the changes makes readings repeat; a finer one is seen
    # as noise in the differences anyway.
    steps = change[change > _SAME]
    if steps.size == 0 or steps.size > 0.95 * change.size or steps.min() > _COARSEST:
        return 0.0
    return float(steps.min())
