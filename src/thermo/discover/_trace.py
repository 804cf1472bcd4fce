"""What is left over time: whether it is white, and whether it follows what is known of the run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, final

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.lib.stride_tricks import sliding_window_view

from thermo._compiled import program
from thermo.discover._standing import Standing
from thermo.inverse import one_run
from thermo.physics.effects import Schedule

# Draws of noise that a chance is read from [1]; the largest lag over the length of a run [1].
_DRAWS: Final = 2000
_LAGS: Final = 0.25

Series = Float[np.ndarray, " frames"]


@final
@dataclass(frozen=True)
class Follows:
    """How far the mean residual follows an input, at the lag where it does most.

    - `score`: in standard deviations [1], positive where the simulation reads more; `lag`: by how
      much later [s]; `p_value`: that noise follows it as far at any lag [1].
    """

    score: float
    lag: float
    p_value: float


@final
@dataclass(frozen=True)
class Trace:
    """The residual of a run over time.

    - `slow`: chance [1] that noise has as much more of slow changes than of fast ones.
    - `inputs`: by name what is known of the run and not constant, `lamp` and `temperature`.
    """

    slow: float
    inputs: Mapping[str, Follows]


def traces(standing: Standing) -> dict[str, Trace]:
    """Of each run, by its name, what is left over time in what is allowed for [1]."""
    coarse, found = standing.bench.coarse, {}
    blocks = iter(standing.allowed.runs)
    for case in coarse.cases:
        for row in range(len(case.data)):
            block = next(blocks)
            time, data, used = (np.asarray(leaf)[row] for leaf in (case.time, case.data, case.used))
            # A run that others outlast is filled up with its last time.
            own = np.append(True, np.diff(time) > 0)
            schedule = one_run(case.under.schedule, row)
            weight = np.maximum(used.sum(1), 1.0)
            inputs = {
                "lamp": np.asarray(_shares(schedule, jnp.asarray(time)))[own],
                "temperature": ((data * used).sum(1) / weight)[own],
            }
            left = standing.ended.residual[block.part].reshape(block.shape)[own]
            found[block.name] = _trace(left, inputs, time[own])
    return found


@program
def _shares(schedule: Schedule, time: Float[Array, " frames"]) -> Float[Array, " frames"]:
    return jax.vmap(schedule.share)(time)


def _trace(
    left: Float[np.ndarray, "frames samples"], inputs: Mapping[str, Series], time: Series
) -> Trace:
    count = np.maximum(np.count_nonzero(left, axis=1), 1)
    mean = left.sum(1) / np.sqrt(count)
    step = float(np.median(np.diff(time)))
    followed = {
        name: follows(mean, one, step) for name, one in inputs.items() if np.ptp(one) > 1e-9
    }
    return Trace(slow_excess(left), followed)


def slow_excess(left: Float[np.ndarray, "frames samples"]) -> float:
    """Chance [1] that white noise has as large an excess in its cumulated periodogram.

    The periodograms of all samples are added. What is allowed for takes slow changes off, so that
    only an excess counts: the largest of the cumulated share less that of white noise.

    Source: Durbin, Biometrika 56 (1969) 1, tests for serial correlation from the periodogram.
    """
    seen = left[:, np.any(left != 0, axis=0)]
    power = (np.abs(np.fft.rfft(seen, axis=0))[1:] ** 2).sum(1)
    random = np.random.default_rng(0)
    noise = random.gamma(max(seen.shape[1], 1), size=(_DRAWS, len(power)))
    return float(np.mean(_excess(noise) >= _excess(power[None])[0]))


def _excess(power: Float[np.ndarray, "draws tones"]) -> Float[np.ndarray, " draws"]:
    share = np.cumsum(power, 1) / np.maximum(power.sum(1, keepdims=True), 1e-300)
    even = np.arange(1, power.shape[1] + 1) / power.shape[1]
    return np.max(share - even, axis=1)


def follows(mean: Series, known: Series, step: float) -> Follows:
    """How far a residual of variance one follows an input that comes before it.

    Arguments: `mean`: [1]; `known`: in any unit; `step`: between frames [s].
    """
    lags = max(int(_LAGS * len(known)), 1)
    # Before the run an input was what it is at first.
    longer = np.concatenate([np.full(lags, known[0]), known])
    shifted = sliding_window_view(longer, len(known))[::-1]
    apart = shifted - shifted.mean(1, keepdims=True)
    size = np.linalg.norm(apart, axis=1, keepdims=True)
    # An input that does not change by then is followed by nothing.
    shapes = np.where(size > 1e-6 * size.max(), apart / np.maximum(size, 1e-300), 0.0)
    scores = shapes @ mean
    best = int(np.argmax(np.abs(scores)))
    noise = np.random.default_rng(0).standard_normal((len(mean), _DRAWS))
    largest = np.max(np.abs(shapes @ noise), axis=0)
    chance = float(np.mean(largest >= abs(scores[best])))
    return Follows(float(scores[best]), best * step, chance)
