"""What each sample reads wrong all the time, as a model's misfit tells it."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from thermo.inverse._case import common_deviations, constant_error
from thermo.observe import Run


def staying(apart: Float[np.ndarray, "frames samples"], run: Run) -> Float[np.ndarray, " samples"]:
    """The constant error of each sample [K], where a run or its noise tells how large it may be.

    Its mean given the differences `apart` of readings and simulation [K], NaN where there is none:
    their mean times s^2 / (s^2 + v), s the deviation that is stated, v the variance of that mean.

    Source: Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), section 2.1.
    """
    noise = run.noise_of_readings()
    size = max(run.constant_error, noise.offset)
    if not size or run.recording.knows_quiet():
        return np.zeros(apart.shape[1])
    known = np.isfinite(apart)
    count = known.sum(0)
    mean = np.where(known, apart, 0.0).sum(0) / np.maximum(count, 1)
    own = noise.mean_variance(np.maximum(count, 1))
    return np.where(count > 0, mean / (1 + own / size**2), 0.0)


def left_open(run: Run) -> Float[np.ndarray, " samples"]:
    """Variance of what quiet frames leave of each sample's constant error [K2], zero without them.

    A reading less what its sample reads at rest scatters by that as well, alike in all frames.
    """
    if not run.recording.knows_quiet():
        return np.zeros(len(run.recording.points))
    noise = run.noise_of_readings()
    return constant_error(run, noise)[1] + common_deviations(run, noise)[1] ** 2
