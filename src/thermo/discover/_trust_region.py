"""Least squares on coarse cells, kept near where these were held against fine ones."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from jax.flatten_util import ravel_pytree

from thermo.discover._descent import Free
from thermo.discover._extended import Extended
from thermo.discover._standing import (
    Standing,
    descended,
    free_of,
    measured,
    not_moved,
    with_all_places,
    with_few_places,
)

# How far entries may go at first, in changes that are large [1], and steps at the most.
_REACH: Final = 0.5
_STEPS: Final = 10
# Of what a step promised, the share that it has to keep for the next to be as long, and the share
# from which that is twice as long [1].
_POOR: Final = 0.25
_GOOD: Final = 0.75
# A step that promises less than this, of what those before it gained, is not worth a measurement.
_ENOUGH: Final = 0.003
# Gain [1] that is none.
_NOTHING: Final = 0.05
# Steps by which their pace is judged [1]: the first may be as long as where cells were measured
# allows, and no longer.
_PACE: Final = 3


def remeasured(standing: Standing) -> Standing:
    """What is left where it stands once what cells make wrong is measured there [1]."""
    small, kept = with_few_places(standing)
    return with_all_places(standing, not_moved(measured(small), free_of(small)), kept)


def kept_promise(before: Standing, after: Standing, there: Standing) -> bool:
    """Whether a fit gains what it seemed to.

    Arguments, all with what is left [1]: `before` a fit; `after` it, by the cells that it was made
    on; `there`: the same place, what cells make wrong measured where it is.
    """
    promised = before.ended.loss() - after.ended.loss()
    return before.ended.loss() - there.ended.loss() >= _POOR * promised


def in_short_steps(standing: Standing, rival: float = np.inf) -> Standing:
    """Least squares in steps, after each of which what cells make wrong is measured anew [1].

    Coarse cells with their error taken off where it was measured stand for fine ones near that
    place alone. A step that leaves more on the fine ones is taken back; how far the next may go
    follows from how much of its promise a step has kept.

    `standing`: before the fit, what cells make wrong measured where it stands; `rival`: a loss [1]
    that it has to reach, and ends where the steps that are left would not at twice the pace of the
    best of the last few.

    Source: Alexandrov, Dennis, Lewis and Torczon, Structural Optimization 15 (1998) 16, a trust
    region for approximation models of which value and slope need not be exact at a distance.
    """
    small, kept = with_few_places(standing)
    free, reach, gains = free_of(small), _REACH, []
    here = first = not_moved(small, free)
    for left in range(_STEPS - 1, -1, -1):
        there = descended(here, _near(free, here.point, reach))
        promised = here.ended.loss() - there.ended.loss()
        if promised < max(_NOTHING, _ENOUGH * (first.ended.loss() - here.ended.loss())):
            break
        there = not_moved(measured(there), free)
        gains.append(here.ended.loss() - there.ended.loss())
        here = there if gains[-1] > 0 else here
        late = here.ended.loss() - 2 * left * max(0.0, *gains[-_PACE:]) > rival
        if len(gains) >= _PACE and late:
            break
        share = gains[-1] / promised
        reach *= 2.0 if share >= _GOOD else 1.0 if share >= _POOR else 0.25
    return with_all_places(standing, here, kept)


def _near(free: Free, point: Extended, reach: float) -> Free:
    """The same entries, none farther from the point than `reach` in changes that are large [1]."""
    here = np.asarray(ravel_pytree(point)[0])[free.number]
    low = np.maximum(free.low, here - reach * free.scale)
    high = np.minimum(free.high, here + reach * free.scale)
    return replace(free, low=low, high=high)
