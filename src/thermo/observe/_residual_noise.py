"""The noise of a recording without quiet frames, from what a fit leaves of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from ._noise import FLOOR, LEAST_FRAMES, LEAST_SAMPLES, Noise, rounding
from ._quiet_check import first_order_misfit, jackknife, squares
from ._recording import Recording

_FAR: Final = 5.0
"""Differences further off than so many robust deviations [1] are left out."""

_MEDIAN_EFFICIENCY: Final = 0.37
"""Of the median absolute deviation against the standard deviation [1]."""

_CHANCE: Final = 4.0
"""Standard errors [1] from which a change over the run is more than chance."""


@final
@dataclass(frozen=True)
class ResidualNoise:
    """Noise as the residual of a fit shows it, and what in the residual is none.

    - `noise`: of the recording [K]; its offset is that by which samples are off from their
      neighbours all the time.
    - `z`: by how many standard errors the fluctuation is not first-order autoregressive [1].
    - `changing`: by how much samples drift from their neighbours from the first half of the run to
      the second [K], as a standard deviation; zero where chance may have done it. No noise does so.
    - `apart`: median distance of neighbours [m]. A misfit that varies over less looks like offsets.
    """

    noise: Noise
    z: float
    changing: float
    apart: float

    def words(self) -> str:
        """A sentence for each thing that a reader should know, or that all is as it should be."""
        found = []
        if abs(self.z) > 3:
            found.append(
                f"What fluctuates is not first-order autoregressive ({self.z:.1f} standard errors)."
            )
        if self.changing > 0:
            found.append(
                f"Residuals of neighbours drift apart by {self.changing:.2g} K over the run: that "
                "is a misfit and no noise, and no interval allows for it."
            )
        if self.noise.offset > 0:
            found.append(
                f"Neighbours, {1e3 * self.apart:.2g} mm apart, differ by {self.noise.offset:.2g} K "
                "all the time: samples are off by that, or a misfit varies over so short a way."
            )
        return " ".join(found) or "The residual is as the noise model has it."


def residual_noise(
    recording: Recording,
    residual: Float[np.ndarray, "fitted samples"],
    frames: Int[np.ndarray, " fitted"],
) -> ResidualNoise | None:
    """The noise [K] of a recording from a fit's residual; None where there is too little of it.

    A misfit of the model is no noise, and most of it is smooth over the body and over time. So
    differences between each sample and the one nearest to it, over sqrt(2), are looked at alone:

    - white level and correlation from their mean squares over one and two frames, as
      `estimate_noise` has them of quiet frames; differences beyond five robust deviations are left
      out;
    - the offset from their means over the first and the second half of the run: the variance that
      both have in common, (mad(a + b)^2 - mad(a - b)^2) / 4. By what they differ beyond what
      fluctuates is `changing`.

    A misfit that neither varies in time nor is smooth from neighbour to neighbour cannot be told
    from offsets, and counts as such.

    Arguments:

    - `residual`: simulated less measured [K], NaN where there is no reading.
    - `frames`: numbers of the recording's frames that were fitted, rising.

    Source: von Neumann, Ann. Math. Statist. 12 (1941) 367, successive differences; Gnanadesikan and
    Kettenring, Biometrics 28 (1972) 81, the robust covariance.
    """
    seen = np.isfinite(residual).sum(0) >= 2 * LEAST_FRAMES
    if len(residual) < 2 * LEAST_FRAMES or seen.sum() < LEAST_SAMPLES:
        return None
    apart, distance = _between_neighbours(residual[:, seen], recording.points[seen])
    sums = np.stack([squares(apart, lag, far=_FAR) for lag in (1, 2, 3)])
    (one, two, _) = sums[:, 0].sum(-1) / np.maximum(sums[:, 1].sum(-1), 1)
    if not one > 0:
        return None
    kept = float(np.clip(two / one - 1.0, 0.0, 0.95))
    white = math.sqrt(one / (2.0 * (1.0 - kept)))
    offset, changing = _halves(apart, Noise(white, 0.0, kept))
    misfit, error = first_order_misfit(sums.sum(-1)), jackknife(sums)
    every = float(np.mean(np.diff(frames)))
    floor = max(rounding(recording) / math.sqrt(12.0), FLOOR)
    # The correlation is that of the fitted frames; of those between it is the root.
    noise = Noise(max(white, floor), offset, kept ** (1.0 / every) if kept > 0 else 0.0)
    return ResidualNoise(noise, misfit / error if error > 0 else 0.0, changing, distance)


def _between_neighbours(
    residual: Float[np.ndarray, "fitted samples"], points: Float[np.ndarray, "samples 3"]
) -> tuple[Float[np.ndarray, "fitted pairs"], float]:
    """Differences of nearest samples over sqrt(2) [K], each pair once, and how far they lie [m]."""
    length, near = map(np.asarray, KDTree(points).query(points, k=2))
    mine = np.arange(len(points))
    # Of samples in one place either may come first.
    other = np.where(near[:, 0] == mine, near[:, 1], near[:, 0])
    pairs = np.unique(np.sort(np.stack([mine, other], 1), axis=1), axis=0)
    apart = (residual[:, pairs[:, 0]] - residual[:, pairs[:, 1]]) / np.sqrt(2)
    return apart, float(np.median(length[:, 1]))


def _halves(apart: Float[np.ndarray, "fitted pairs"], noise: Noise) -> tuple[float, float]:
    """What stays over both halves of the run, and what changes between them [K]."""
    middle = len(apart) // 2
    means, variances = [], []
    for part in (apart[:middle], apart[middle:]):
        known = np.isfinite(part)
        count = known.sum(0)
        means.append(np.where(known, part, 0.0).sum(0) / np.maximum(count, 1))
        variances.append(np.where(count > 0, noise.mean_variance(np.maximum(count, 1)), np.nan))
    there = np.all(np.isfinite(variances), axis=0)
    first, second = (mean[there] for mean in means)
    own = float(np.mean(np.array(variances)[:, there])) if there.any() else 0.0
    if there.sum() < LEAST_SAMPLES // 2:
        return 0.0, 0.0
    staying = (_spread(first + second) ** 2 - _spread(first - second) ** 2) / 4
    moving = _spread(first - second) ** 2
    scatter = own * math.sqrt(2 / (_MEDIAN_EFFICIENCY * there.sum()))
    drift = moving - 2 * own
    changing = math.sqrt(drift) if drift > 2 * _CHANCE * scatter else 0.0
    # Where there is none the common variance scatters about zero.
    lasting = math.sqrt(staying) if staying > scatter else 0.0
    return lasting, changing


def _spread(values: Float[np.ndarray, " pairs"]) -> float:
    """Robust standard deviation about zero: the sign of a pair is arbitrary."""
    return 1.4826 * float(np.median(np.abs(values)))
