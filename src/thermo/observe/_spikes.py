"""Single readings that stick out of their sample's course."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Final

import numpy as np
from jaxtyping import Bool, Float
from scipy.stats import norm

from ._recording import Recording
from ._scene import Run, Scene

# Frames on either side from which a reading is foretold; frames around it over which the scale of
# these errors is taken; frames after a jump of the sources that are left alone [1].
_BESIDE: Final = 5
_AROUND: Final = 8
_FRESH: Final = 8
# Readings of a recording without spikes that are dropped all the same, on the average [1].
_FALSE: Final = 0.01
# Two spikes nearby hide each other until one is gone; rounds at the most [1].
_ROUNDS: Final = 5
_LEAST: Final = 3e-5


def without_spikes(scene: Scene) -> tuple[Scene, dict[str, int]]:
    """The scene without single readings far out, and how many of each run were dropped [1].

    A reading is foretold by straight lines through the five before it and through the five after
    it, which one bad reading among them does not bend. Where both miss it to the same side, and by
    more than normal errors would once in a hundred recordings, it is dropped. Errors are scaled by
    their median absolute value, over the recording and over the frames nearby, so that a course
    that bends does not count. Eight frames after the start and after a lamp goes off are left
    alone. No simulation is asked: what a model does not explain stays.

    Arguments: `scene`: with its recordings [K].

    Source: Sen, J. Am. Stat. Assoc. 63 (1968) 1379, the lines by medians; Hampel, J. Am. Stat.
    Assoc. 69 (1974) 383, the median absolute deviation; Davies and Gather, J. Am. Stat. Assoc. 88
    (1993) 782, the limit by the number of readings.
    """
    runs, counts = {}, {}
    for name, run in scene.runs.items():
        record = run.recording
        found = spikes(run)
        counts[name] = int(found.sum())
        kept = Recording(
            record.points, record.time, record.temperature, record.valid & ~found, record.quiet
        )
        runs[name] = replace(run, recording=kept)
    return replace(scene, runs=runs), counts


def spikes(run: Run) -> Bool[np.ndarray, "frames samples"]:
    """Which readings stick out; as `without_spikes` says [1]."""
    record = run.recording
    limit = float(norm.isf(_FALSE / 2 / record.valid.sum()))
    alone = _left_alone(run)
    found = np.zeros_like(record.valid)
    for _ in range(_ROUNDS):
        known = record.valid & ~found
        # From the left, and with time turned round from the right.
        before = _missed_by(record.time, record.temperature, known)
        after = _missed_by(-record.time[::-1], record.temperature[::-1], known[::-1])[::-1]
        scale = np.maximum(_scale(before), _scale(after))
        apart = np.minimum(np.abs(before), np.abs(after))
        far = (np.sign(before) == np.sign(after)) & (apart > limit * scale)
        fresh = far & known & ~alone[:, None]
        if not fresh.any():
            break
        # Of several within reach of each other the largest goes first: it may bend their lines.
        found |= fresh & (apart == _windows(np.where(fresh, apart, 0.0), _BESIDE, 0.0).max(-1))
    return found


def _left_alone(run: Run) -> Bool[np.ndarray, " frames"]:
    """Frames at which a course may truly jump or bend sharply."""
    time = run.recording.time
    jumps = [0.0] if run.heater is None else [0.0, float(run.heater.until)]
    alone = np.zeros(len(time), bool)
    for jump in jumps:
        first = int(np.searchsorted(time, jump))
        alone[max(first - 1, 0) : first + _FRESH] = True
    return alone


def _missed_by(
    time: Float[np.ndarray, " frames"],
    values: Float[np.ndarray, "frames samples"],
    known: Bool[np.ndarray, "frames samples"],
) -> Float[np.ndarray, "frames samples"]:
    """Readings less the straight line through those before them [K]; NaN where there are few."""
    before = [
        _earlier(np.where(known, values, np.nan), lag) - values for lag in range(1, _BESIDE + 1)
    ]
    back = [_earlier(time[:, None], lag) - time[:, None] for lag in range(1, _BESIDE + 1)]
    pairs = itertools.combinations(range(_BESIDE), 2)
    slope = _median([(before[i] - before[j]) / (back[i] - back[j]) for i, j in pairs])
    line = _median([here - slope * apart for here, apart in zip(before, back, strict=True)])
    enough = np.sum(np.isfinite(before), axis=0) >= 3
    return np.where(enough, -line, np.nan)


def _earlier(values: Float[np.ndarray, "frames columns"], lag: int) -> np.ndarray:
    """What was `lag` frames before [1], NaN at the beginning."""
    shifted = np.full_like(values, np.nan)
    shifted[lag:] = values[:-lag]
    return shifted


def _median(parts: list[np.ndarray]) -> np.ndarray:
    """Of what is known; zero where nothing is."""
    stacked = np.stack(parts)
    return np.nanmedian(np.where(np.isnan(stacked).all(0), 0.0, stacked), axis=0)


def _scale(error: Float[np.ndarray, "frames samples"]) -> Float[np.ndarray, "frames samples"]:
    """Standard deviation of such errors by their median size, overall and nearby [K]."""
    size = 1.4826 * np.abs(error)
    nearby = _windows(size, _AROUND, np.nan)
    filled = np.where(np.isnan(nearby).all(-1, keepdims=True), 0.0, nearby)
    return np.maximum(np.nanmedian(filled, axis=-1), max(float(np.nanmedian(size)), _LEAST))


def _windows(
    values: Float[np.ndarray, "frames samples"], reach: int, beyond: float
) -> Float[np.ndarray, "frames samples around"]:
    """Values of the frames about each one, `beyond` the record's ends."""
    padded = np.pad(values, ((reach, reach), (0, 0)), constant_values=beyond)
    return np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1, axis=0)
