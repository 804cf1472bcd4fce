"""Single readings that stick out of their sample's course."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Final

import numpy as np
from jaxtyping import Bool, Float
from scipy.stats import norm

from ._noise import FLOOR, rounding
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
# A thermometer that flickers between neighbours of its grid has no spike; a spike is further off
# than this many of its steps [1].
_STEPS: Final = 2.0
# From the median absolute value of normal errors to their standard deviation [1].
_NORMAL: Final = 1.4826


def without_spikes(scene: Scene) -> tuple[Scene, dict[str, int]]:
    """The scene without single readings far out, and how many of each run were dropped [1].

    A reading is foretold by straight lines through the five before it and through the five after
    it, which one bad reading among them does not bend. Where both miss it to the same side, and by
    more than normal errors would once in a hundred recordings, it is dropped. Errors are scaled by
    their median absolute value, over the recording and over the frames nearby, so that a course
    that bends does not count. Eight frames after the start and after a lamp goes off are left
    alone. Quiet frames are judged by their distance from their sample's median. No simulation is
    asked: what a model does not explain stays.

    Arguments: `scene`: with its recordings [K].

    Source: Sen, J. Am. Stat. Assoc. 63 (1968) 1379, the lines by medians; Hampel, J. Am. Stat.
    Assoc. 69 (1974) 383, the median absolute deviation; Croux and Rousseeuw, Comput. Stat. 1 (1992)
    411, that of few; Davies and Gather, J. Am. Stat. Assoc. 88 (1993) 782, the limit by the number
    of readings.
    """
    runs, counts = {}, {}
    for name, run in scene.runs.items():
        record = run.recording
        found, quiet = spikes(run), _quiet_left(record)
        valid = record.valid & ~found
        kept = Recording(record.points, record.time, record.temperature, valid, quiet)
        counts[name] = int(found.sum()) + _missing(quiet) - _missing(record.quiet)
        runs[name] = replace(run, recording=kept)
    return replace(scene, runs=runs), counts


def spikes(run: Run) -> Bool[np.ndarray, "frames samples"]:
    """Which readings stick out; as `without_spikes` says [1]."""
    record = run.recording
    found = np.zeros_like(record.valid)
    if len(record.time) <= _BESIDE:
        return found
    limit, least = _limit(int(record.valid.sum())), _STEPS * rounding(record)
    alone = _left_alone(run)
    for _ in range(_ROUNDS):
        known = record.valid & ~found
        # From the left, and with time turned round from the right.
        before = _missed_by(record.time, record.temperature, known)
        after = _missed_by(-record.time[::-1], record.temperature[::-1], known[::-1])[::-1]
        scale = np.maximum(_scale(before), _scale(after))
        apart = np.minimum(np.abs(before), np.abs(after))
        far = (np.sign(before) == np.sign(after)) & (apart > np.maximum(limit * scale, least))
        fresh = far & known & ~alone[:, None]
        if not fresh.any():
            break
        # Of several within reach of each other the largest goes first: it may bend their lines.
        found |= fresh & (apart == _windows(np.where(fresh, apart, 0.0), _BESIDE, 0.0).max(-1))
    return found


def _limit(count: int) -> float:
    """Standard deviations [1] that so many normal errors hardly ever pass."""
    return float(norm.isf(_FALSE / 2 / count))


def _quiet_left(record: Recording) -> Float[np.ndarray, "quiet samples"] | None:
    """The quiet frames [K], NaN where a reading is far from its sample's median."""
    quiet = record.quiet
    if quiet is None or len(quiet) <= _BESIDE:
        return quiet
    apart = np.abs(quiet - _median(list(quiet)))
    known = np.isfinite(apart)
    # The median of few frames lies too near to each: Croux and Rousseeuw's factor for deviations
    # from it, and the variance that it adds to a reading's.
    few = len(quiet) / (len(quiet) - 0.8) * np.sqrt(1 + np.pi / 2 / len(quiet))
    scale = max(few * _NORMAL * float(np.median(apart[known])), FLOOR) if known.any() else np.inf
    far = apart > max(_limit(int(known.sum())) * scale, _STEPS * rounding(record))
    return np.where(far, np.nan, quiet)


def _missing(quiet: Float[np.ndarray, "quiet samples"] | None) -> int:
    return 0 if quiet is None else int(np.isnan(quiet).sum())


def _left_alone(run: Run) -> Bool[np.ndarray, " frames"]:
    """Frames at which a course may truly jump or bend sharply."""
    time = run.recording.time
    alone = np.zeros(len(time), bool)
    for jump in (0.0, *run.switches()):
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
    size = _NORMAL * np.abs(error)
    nearby = _windows(size, _AROUND, np.nan)
    filled = np.where(np.isnan(nearby).all(-1, keepdims=True), 0.0, nearby)
    return np.maximum(np.nanmedian(filled, axis=-1), max(float(np.nanmedian(size)), FLOOR))


def _windows(
    values: Float[np.ndarray, "frames samples"], reach: int, beyond: float
) -> Float[np.ndarray, "frames samples around"]:
    """Values of the frames about each one, `beyond` the record's ends."""
    padded = np.pad(values, ((reach, reach), (0, 0)), constant_values=beyond)
    return np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1, axis=0)
