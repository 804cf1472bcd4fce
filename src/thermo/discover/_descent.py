"""Least squares over a few entries of a point, within bounds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Bool, Float, Int

from thermo.discover._allowance import Allowance
from thermo.discover._extended import Extended, columns, moved
from thermo.inverse import Objective

# Trials at the most, share of the loss beyond noise and absolute gain [1] below which a fit has
# ended.
_TRIALS: Final = 20
_SHARE: Final = 1e-4
_GAIN: Final = 0.05
# Foretold gain [1] for which no step is tried: simulations are no more exact than that.
_NOTHING: Final = 0.005
# Damping over each entry's own curvature [1]. An effect and an unknown that hides all of it but a
# hundredth leave 1e-4 of it along what tells them apart: from well below that the first step is
# nearly Newton's, and small gains at more are no end.
_DAMPING: Final = 1e-8
_LITTLE: Final = 1e-6
# Steps by which the pace of a fit is judged [1]: the first ones may turn into a narrow valley.
_PACE: Final = 3
# What a step promises all the way to its end [1], of which so many times are still hoped for.
_HOPE: Final = 10.0


@final
@dataclass(frozen=True)
class Free:
    """Entries of a flattened point that are free.

    - `number`: (free,) [1]; `scale`: a change that is large, `low`, `high`: bounds, each (free,) in
      the unit of its entry.
    - `logarithm`: (free,), which entries are logarithms of what they stand for.
    """

    number: Int[np.ndarray, " free"]
    scale: Float[np.ndarray, " free"]
    low: Float[np.ndarray, " free"]
    high: Float[np.ndarray, " free"]
    logarithm: Bool[np.ndarray, " free"]

    def after(
        self, before: Float[np.ndarray, " free"], step: Float[np.ndarray, " free"]
    ) -> Float[np.ndarray, " free"]:
        """Entries one step on, within their bounds, each in its unit.

        A logarithm moves so that its value changes by the step's share of it: coefficients of
        exchange add up, so that one that gives way to another does so along a straight line, which
        is a narrow curve to their logarithms.
        """
        most = 2 * self.scale
        step = np.clip(step, -most, most)
        step[self.logarithm] = np.log1p(np.maximum(step[self.logarithm], -0.9))
        return np.clip(before + step, self.low, self.high)

    def ways(self, entries: int) -> Float[np.ndarray, "free entries"]:
        """One way for each, its length the scale, in each entry's unit."""
        made = np.zeros((len(self.number), entries))
        made[np.arange(len(self.number)), self.number] = self.scale
        return made


@final
@dataclass(frozen=True)
class Ended:
    """Where least squares ended.

    - `point`; `residual`: (values,), `slopes`: (values, free) by scaled entries, both measured in
      what is allowed for [1].
    """

    point: Extended
    residual: Float[np.ndarray, " values"]
    slopes: Float[np.ndarray, "values free"]

    def loss(self) -> float:
        """Half the sum of squares [1]."""
        return 0.5 * float(self.residual @ self.residual)

    def fitted(self) -> int:
        """How many entries were free [1]."""
        return self.slopes.shape[1]

    def criterion(self, spread: float) -> float:
        """Akaike's criterion with a variance of `spread`, 2 loss / spread + 2 fitted [1].

        Source: Burnham and Anderson, Model Selection (2002), section 2.5, QAIC.
        """
        return 2 * self.loss() / spread + 2 * self.fitted()


def descend(
    objective: Objective,
    point: Extended,
    free: Free,
    allowed: Allowance,
    rival: float = np.inf,
) -> Ended:
    """Levenberg-Marquardt in scaled entries; a step that meets a bound ends on it.

    Residuals are measured in what is `allowed` for [1]. It ends as well where the steps that are
    left would not reach the loss of a `rival` [1] at twice the pace of the best of the last few, or
    where ten times what the linear model promises, after the first step, would not.

    Source: Madsen, Nielsen and Tingleff, Methods for Non-Linear Least Squares Problems (2004), 3.2.
    """
    entries = len(ravel_pytree(point)[0])
    ways = free.ways(entries)
    here = _at(objective, point, ways, allowed)
    damping, gains = _DAMPING, []
    for left in range(_TRIALS - 1, -1, -1):
        normal = here.slopes.T @ here.slopes
        level = np.sqrt(np.maximum(np.diag(normal), 1e-12))
        alike = normal / np.outer(level, level) + damping * np.eye(len(level))
        slope = here.slopes.T @ here.residual / level
        step = -np.linalg.solve(alike, slope)
        promised = -slope @ step / 2
        hopeless = gains and here.loss() - _HOPE * promised > rival
        if damping <= _LITTLE and (promised < _NOTHING or hopeless):
            break
        step *= free.scale / level
        old = np.asarray(ravel_pytree(here.point)[0])[free.number]
        change = np.zeros(entries)
        change[free.number] = free.after(old, step) - old
        if not np.any(change):
            break
        there = _at(objective, moved(here.point, change), ways, allowed)
        gain = here.loss() - there.loss()
        if np.isfinite(gain) and gain > 0:
            beyond = there.loss() - 0.5 * len(there.residual)
            small = gain < max(_GAIN, _SHARE * beyond) and damping <= _LITTLE
            here, damping = there, max(damping / 10, _DAMPING)
            gains.append(gain)
            late = here.loss() - 2 * left * max(gains[-_PACE:]) > rival
            if small or (len(gains) >= _PACE and late):
                break
        else:
            damping *= 100
            if damping > 1e4:
                break
    return here


def begun(objective: Objective, point: Extended, free: Free, allowed: Allowance) -> Ended:
    """Where least squares begin, residual and slopes in what is `allowed` for [1]."""
    return _at(objective, point, free.ways(len(ravel_pytree(point)[0])), allowed)


def _at(
    objective: Objective,
    point: Extended,
    ways: Float[np.ndarray, "free entries"],
    allowed: Allowance,
) -> Ended:
    raw, slopes = columns(objective, point, ways)
    residual = allowed.whiten(raw[:, None])[:, 0]
    return Ended(point, residual, allowed.whiten(slopes))
