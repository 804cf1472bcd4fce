"""How many independent values a correlated residual is worth."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial.distance import cdist

# Neighbours whose mean correlation says whether a residual still hangs together over a distance.
_WINDOW: Final = 6
# Distances between more samples than this are taken from some of them.
_MOST: Final = 1500


def _over_time(error: Float[np.ndarray, "frames samples"]) -> float:
    """Frames that say the same: 1 + 2 sum of correlations over time, until one is not positive."""
    whole = float(np.sum(error**2))
    total = 1.0
    for lag in range(1, len(error)):
        together = float(np.sum(error[lag:] * error[:-lag])) / whole
        if together <= 0:
            break
        total += 2 * together
    return total


def _over_space(
    error: Float[np.ndarray, "frames samples"], points: Float[np.ndarray, "samples 3"]
) -> float:
    """Samples that say the same: 1 + sum of correlations with neighbours, nearest first."""
    picked = np.arange(len(points))
    if len(points) > _MOST:
        picked = np.random.default_rng(0).choice(len(points), _MOST, replace=False)
    part, place = error[:, picked], points[picked]
    near = np.argsort(cdist(place, place), axis=1)[:, 1:]
    together = np.take_along_axis(part.T @ part, near, axis=1).mean(0)
    together *= len(picked) / float(np.sum(part**2))
    # The mean over a window, so that one negative value among many positive ones is no end.
    means = np.convolve(together, np.ones(_WINDOW) / _WINDOW, mode="valid")
    ends = np.flatnonzero(means <= 0)
    reach = int(ends[0]) if ends.size else len(together)
    return 1.0 + float(together[:reach].sum()) * len(points) / len(picked)


def repeats(
    error: Float[np.ndarray, "frames samples"],
    known: Bool[np.ndarray, "frames samples"],
    points: Float[np.ndarray, "samples 3"],
) -> float:
    """How many values of a residual say the same thing [1], 1 where they are independent.

    A sum of N values with correlations rho has the variance of N / V independent ones, times V^2,
    V = 1 + sum of rho over all others. The correlation is taken as one over time times one over
    space, each summed until it is no longer positive (Geyer's initial sequence).

    Arguments:

    - `error`: residual in any unit; values that are not `known` do not count.
    - `points`: where the samples are [m].

    Source: C. J. Geyer, Statistical Science 7 (1992) 473, section 3.3; G. V. Bayley and
    J. M. Hammersley, J. Roy. Statist. Soc. Suppl. 8 (1946) 184.
    """
    error = np.where(known, error, 0.0)
    if not np.any(error):
        return 1.0
    along = _over_time(error) if len(error) > 1 else 1.0
    across = _over_space(error, points) if len(points) > _WINDOW else 1.0
    return max(along, 1.0) * max(across, 1.0)
