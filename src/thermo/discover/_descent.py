"""Least squares over a few entries of a point, within bounds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Bool, Float, Int
from scipy.optimize import lsq_linear

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
# nearly Newton's, and one small gain at more is no end.
_DAMPING: Final = 1e-8
_LITTLE: Final = 1e-6
# Damping at the least after a step that leaves more: between that and the first it is one step as
# a rule, which leaves more again.
_MUCH: Final = 1e-2
# Shares of its promise that a step keeps where the next may be longer, or has to be shorter [1].
_GOOD: Final = 0.75
_POOR: Final = 0.25
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

    def but(self, held: Int[np.ndarray, "*any"]) -> Free:
        """Without the entries of these numbers [1]."""
        kept = ~np.isin(self.number, held)
        return Free(
            self.number[kept], self.scale[kept], self.low[kept], self.high[kept],
            self.logarithm[kept],
        )  # fmt: skip

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

    def ends(
        self, before: Float[np.ndarray, " free"]
    ) -> tuple[Float[np.ndarray, " free"], Float[np.ndarray, " free"]]:
        """The least and the largest step within the bounds, as of `after`, each in its unit."""
        low, high = np.minimum(self.low - before, 0.0), np.maximum(self.high - before, 0.0)
        low[self.logarithm] = np.expm1(low[self.logarithm])
        high[self.logarithm] = np.expm1(high[self.logarithm])
        return low, high

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
    """Levenberg-Marquardt in scaled entries, within their bounds.

    Residuals are measured in what is `allowed` for [1]. It ends as well where the steps that are
    left would not reach the loss of a `rival` [1] at twice the pace of the best of the last few, or
    where ten times what the linear model promises, after the first step, would not.

    Source: Madsen, Nielsen and Tingleff, Methods for Non-Linear Least Squares Problems (2004), 3.2.
    """
    entries = len(ravel_pytree(point)[0])
    ways = free.ways(entries)
    here = _at(objective, point, ways, allowed)
    damping, gains, failed = _DAMPING, [], False
    for left in range(_TRIALS - 1, -1, -1):
        old = np.asarray(ravel_pytree(here.point)[0])[free.number]
        step, promised = _step(here, free, old, damping)
        hopeless = gains and here.loss() - _HOPE * promised > rival
        if damping <= _LITTLE and (promised < _NOTHING or hopeless):
            break
        change = np.zeros(entries)
        change[free.number] = free.after(old, step) - old
        if not np.any(change):
            break
        there = _at(objective, moved(here.point, change), ways, allowed)
        gain = here.loss() - there.loss()
        if np.isfinite(gain) and gain > 0:
            beyond = there.loss() - 0.5 * len(there.residual)
            least = max(_GAIN, _SHARE * beyond)
            # Two in a row that gain little are an end however short they were.
            small = gain < least and (damping <= _LITTLE or min(gains[-1:], default=gain) < least)
            here, damping = there, _next(damping, gain, promised, failed=failed)
            failed = False
            gains.append(gain)
            late = here.loss() - 2 * left * max(gains[-_PACE:]) > rival
            if small or (len(gains) >= _PACE and late):
                break
        else:
            damping, failed = max(_MUCH, 10 * damping), True
            if damping > 1e4:
                break
    return here


def _next(damping: float, gain: float, promised: float, *, failed: bool) -> float:
    """Damping [1] after a step that gained so much of what it promised [1].

    `failed`: the one before it left more. What has just been too long would be so again.
    """
    if gain > _GOOD * promised and not failed:
        return max(damping / 100, _DAMPING)
    return 4 * damping if gain < _POOR * promised else damping


def _step(
    here: Ended, free: Free, old: Float[np.ndarray, " free"], damping: float
) -> tuple[Float[np.ndarray, " free"], float]:
    """A damped step from entries `old` within their bounds, in their units, and its promise [1].

    Where some end on a bound, the others step as that leaves it best: they make up for what those
    cannot do, and a fit along a bound does not creep.

    Source: Stark and Parker, Computational Statistics 10 (1995) 129, bounded least squares.
    """
    normal = here.slopes.T @ here.slopes
    level = np.sqrt(np.maximum(np.diag(normal), 1e-12))
    alike = normal / np.outer(level, level) + damping * np.eye(len(level))
    slope = here.slopes.T @ here.residual / level
    unit = free.scale / level
    step = -np.linalg.solve(alike, slope)
    low, high = (end / unit for end in free.ends(old))
    if np.any((step < low) | (step > high)):
        root = np.linalg.cholesky(alike)
        step = lsq_linear(root.T, -np.linalg.solve(root, slope), (low, high), method="bvls").x
    return step * unit, float(-slope @ step - step @ alike @ step / 2)


def newton(here: Ended, free: Free) -> tuple[Float[np.ndarray, " free"], float]:
    """Newton's step within the bounds, each entry in its unit, and what it promises [1].

    Entries that are logarithms move by shares of what they stand for, as of `Free.after`.
    """
    return _step(here, free, np.asarray(ravel_pytree(here.point)[0])[free.number], _DAMPING)


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
