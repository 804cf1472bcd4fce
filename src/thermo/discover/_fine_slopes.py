"""Light below the skin fitted by slopes of the cells that a fit is held against."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Float, Int

from thermo.discover._bench import finer_runs, steps_for
from thermo.discover._descent import Ended, Free, newton
from thermo.discover._entries import entry_of
from thermo.discover._extended import Extended, moved, numbers, whitened
from thermo.discover._pace import MEASURE, Pace
from thermo.discover._standing import (
    Standing,
    free_of,
    lost,
    measured,
    not_moved,
    with_all_places,
    with_few_places,
)
from thermo.discover.candidates import InDepthAbsorption

# Steps at the most, and a step's promise below which it is none [1].
_STEPS: Final = 6
_NOTHING: Final = 0.05
# Of a step that leaves more, how much is tried in its place [1].
_SHORTER: Final = 0.3
# By how much the logarithm of an entry is changed to tell its slope [1].
_CHANGE: Final = 0.05

Numbers = Int[np.ndarray, " some"]
Slopes = Float[np.ndarray, "values some"]


def by_fine_slopes(standing: Standing, doubted: Standing, pace: Pace) -> tuple[Standing, Standing]:
    """Where light below the skin is at work, least squares by slopes of finer cells [1].

    Of light that fades within a cell linear cells see how deep it goes in the mean, and hardly
    more: a share and a depth make up for each other all along a valley, of which finer cells know
    the deepest point. To take off what coarse ones make wrong where a fit stands is not to take off
    what they make wrong of its slopes, by which it moves on.

    `doubted`: the fit with more allowed for. Both come back with such slopes, from which errors
    follow; the first may have moved.

    Source: Alexandrov and Lewis, Optimization and Engineering 2 (2001) 413, models that agree with
    a finer one in value and in slope; Broyden, Math. Comp. 19 (1965) 577, slopes told by a step.
    """
    small, kept = with_few_places(standing)
    free = free_of(small)
    some = _of_light(small, free)
    if not len(some):
        return standing, doubted
    least = {MEASURE: 1 + len(some)}
    pace.step("fitting light below the skin by slopes of finer cells", ahead=least)
    here = begun = not_moved(measured(small), free)
    if lost(begun):
        return standing, doubted
    raw = _fine(here, free, some)
    slopes, share = here.allowed.whiten(raw), 1.0
    for _ in range(_STEPS):
        step, promised = newton(_with(here, some, slopes / _unit(here, free, some)), free)
        if share * promised < _NOTHING:
            break
        there = not_moved(measured(_moved(here, free, some, share * step)), free)
        if there.ended.loss() < here.ended.loss():
            slopes = _told_by(here, there, free, some, slopes)
            here, share = there, min(1.0, 2 * share)
        else:
            share *= _SHORTER
    if here is not begun:
        raw = _fine(here, free, some)
    raw = raw / _unit(here, free, some)
    here, doubted = (
        replace(one, ended=_with(one, some, one.allowed.whiten(raw))) for one in (here, doubted)
    )
    return with_all_places(standing, here, kept), doubted


def _of_light(small: Standing, free: Free) -> Numbers:
    """Which of the free entries are shares and depths of light below the skin [1]."""
    point, every, found = small.point, numbers(small.point).at.candidates, []
    for name, part in small.active:
        entry = entry_of(point, (name, part))
        one, at = point.candidates[entry.kind], every[entry.kind]
        if isinstance(at, InDepthAbsorption) and float(one.strength[part]) > 0:
            found += [float(at.strength[part]), float(at.place.size[part])]
    return np.flatnonzero(np.isin(free.number, found))


def _values(standing: Standing, free: Free) -> Float[np.ndarray, " free"]:
    """The free entries, each in its unit."""
    return np.asarray(ravel_pytree(standing.point)[0])[free.number]


def _to(standing: Standing, free: Free, values: Float[np.ndarray, " free"]) -> Extended:
    """The point with other values of its free entries."""
    change = np.zeros(len(ravel_pytree(standing.point)[0]))
    change[free.number] = values - _values(standing, free)
    return moved(standing.point, change)


def _moved(here: Standing, free: Free, some: Numbers, step: Float[np.ndarray, " free"]) -> Standing:
    """One step on: some entries move as their logarithms do, the others as of `Free.after`.

    A share and a depth that make up for each other do so along a straight line of logarithms.
    """
    old = _values(here, free)
    new = free.after(old, step)
    # A share of next to nothing may be told to grow by more than a number holds.
    by = np.minimum(step[some] / old[some], np.log(free.high[some] / old[some]))
    new[some] = np.clip(old[some] * np.exp(by), free.low[some], free.high[some])
    return replace(here, point=_to(here, free, new))


def _fine(here: Standing, free: Free, some: Numbers) -> Slopes:
    """Slopes of whitened readings by logarithms of entries on the finer mesh [1]."""
    objective = steps_for(here.bench.coarse, here.point)
    base, values = finer_runs(here.bench, here.point), _values(here, free)
    made = np.zeros((len(here.ended.residual), len(some)))
    for number, one in enumerate(some):
        other = values.copy()
        other[one] *= np.exp(_CHANGE)
        by = _CHANGE if other[one] <= free.high[one] else -_CHANGE
        other[one] = values[one] * np.exp(by)
        read = finer_runs(here.bench, _to(here, free, other))
        apart = [jnp.nan_to_num(a - b) / by for a, b in zip(read, base, strict=True)]
        white = np.asarray(whitened(objective, apart))
        made[: len(white), number] = white
    return made


def _told_by(
    before: Standing, after: Standing, free: Free, some: Numbers, slopes: Slopes
) -> Slopes:
    """Slopes by logarithms [1] that tell of the step from one to the other what it has done."""
    old, new = _values(before, free), _values(after, free)
    change = np.log(new[some] / old[some])
    others = np.setdiff1d(np.arange(len(old)), some)
    foretold = slopes @ change
    foretold += before.ended.slopes[:, others] @ ((new - old) / free.scale)[others]
    missing = after.ended.residual - before.ended.residual - foretold
    return slopes + np.outer(missing, change) / max(float(change @ change), 1e-12)


def _unit(here: Standing, free: Free, some: Numbers) -> Float[np.ndarray, " some"]:
    """Changes of scaled entries over those of their logarithms [1]."""
    return (_values(here, free) / free.scale)[some]


def _with(standing: Standing, some: Numbers, slopes: Slopes) -> Ended:
    """Where it stands, with these slopes by some of the free entries in place of its own [1]."""
    made = np.array(standing.ended.slopes)
    made[:, some] = slopes
    return replace(standing.ended, slopes=made)
