"""Least squares over a few entries of a point, within bounds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Float, Int

from thermo.discover._extended import Extended, columns, moved
from thermo.inverse import Objective

# Trials at the most, share of the loss beyond noise and absolute gain [1] below which a fit has
# ended.
_TRIALS: Final = 20
_SHARE: Final = 1e-4
_GAIN: Final = 0.05


@final
@dataclass(frozen=True)
class Free:
    """Entries of a flattened point that are free.

    - `number`: (free,) [1]; `scale`: a change that is large, `low`, `high`: bounds, each (free,) in
      the unit of its entry.
    """

    number: Int[np.ndarray, " free"]
    scale: Float[np.ndarray, " free"]
    low: Float[np.ndarray, " free"]
    high: Float[np.ndarray, " free"]

    def ways(self, entries: int) -> Float[np.ndarray, "free entries"]:
        """One way for each, its length the scale, in each entry's unit."""
        made = np.zeros((len(self.number), entries))
        made[np.arange(len(self.number)), self.number] = self.scale
        return made


@final
@dataclass(frozen=True)
class Ended:
    """Where least squares ended.

    - `point`; `residual`: (values,) [1]; `slopes`: (values, free) by scaled entries [1].
    - `loss`: half the sum of squares [1].
    """

    point: Extended
    residual: Float[np.ndarray, " values"]
    slopes: Float[np.ndarray, "values free"]
    loss: float


def descend(objective: Objective, point: Extended, free: Free) -> Ended:
    """Levenberg-Marquardt in scaled entries; a step that meets a bound ends on it.

    Source: Madsen, Nielsen and Tingleff, Methods for Non-Linear Least Squares Problems (2004), 3.2.
    """
    entries = len(ravel_pytree(point)[0])
    ways = free.ways(entries)
    here = _at(objective, point, ways)
    damping = 1e-3
    for _ in range(_TRIALS):
        normal = here.slopes.T @ here.slopes
        slope = here.slopes.T @ here.residual
        level = damping * np.diag(normal) + 1e-9 * np.diag(normal).max() + 1e-12
        step = -np.linalg.solve(normal + np.diag(level), slope) * free.scale
        old = np.asarray(ravel_pytree(here.point)[0])[free.number]
        new = np.clip(old + np.clip(step, -2 * free.scale, 2 * free.scale), free.low, free.high)
        change = np.zeros(entries)
        change[free.number] = new - old
        if not np.any(change):
            break
        there = _at(objective, moved(here.point, change), ways)
        gain = here.loss - there.loss
        if np.isfinite(there.loss) and gain > 0:
            here, damping = there, damping / 10
            beyond = here.loss - 0.5 * len(here.residual)
            if gain < max(_GAIN, _SHARE * beyond) and damping < 1:
                break
        else:
            damping *= 10
            if damping > 1e4:
                break
    return here


def _at(objective: Objective, point: Extended, ways: Float[np.ndarray, "free entries"]) -> Ended:
    residual, slopes = columns(objective, point, ways)
    return Ended(point, residual, slopes, 0.5 * float(residual @ residual))
