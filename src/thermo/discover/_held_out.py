"""Runs that were not fitted: what a point reads there, against what was recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from jaxtyping import Float

from thermo.discover._bench import Apart, Bench, finer_runs
from thermo.discover._extended import Extended
from thermo.discover._learnt_noise import noise_left, with_noise
from thermo.discover._verdict import Differences, HeldOut
from thermo.errors import InputError
from thermo.inverse import at_once, coarse_tangents, lay_out, left_open, staying
from thermo.observe import Run, variance_error

# Fewer samples than these [1] are no sample of the body; draws of them.
_FEW: Final = 10
_DRAWS: Final = 1000


def held_out(bench: Bench, stated: Extended, extended: Extended) -> Mapping[str, HeldOut]:
    """Both points on the finer mesh, on the runs that the scene holds out [K].

    Infinitely much is left where what is extended leads to temperatures that there cannot be, as a
    law may that holds at those which were fitted only.

    Raises `InputError` where what is stated does.
    """
    scene = bench.task.scene
    runs = tuple(run for run in scene.runs.values() if run.held_out)
    if not runs:
        return {}
    task = replace(bench.task, runs=runs)
    ready = replace(lay_out(task, bench.ready.mesh, bench.ready.stated), fields=bench.ready.fields)
    like = coarse_tangents(task, ready)
    there = replace(bench, task=task, ready=ready, coarse=like)
    before, after = at_once(
        lambda read: read(), (lambda: finer_runs(there, stated), lambda: _read(there, extended))
    )
    assert before is not None, "raised otherwise"
    both = before, before if after is None else after
    found, order = {}, iter(like.sequence)
    for number, case in enumerate(like.cases):
        apart = [np.nan_to_num(np.asarray(read[number]) - np.asarray(case.data)) for read in both]
        for row in range(len(case.data)):
            run = runs[next(order)]
            time = np.asarray(ready.grids[run.name].frame_time)
            here = slice(len(time)), slice(len(run.recording.points))
            used = np.asarray(case.used)[row][here] > 0
            pair = [np.where(used, each[row][here], np.nan) for each in apart]
            found[run.name] = _compared((pair[0], pair[1]), run, time)
    if after is not None:
        return found
    return {name: replace(one, rms_after=float("inf")) for name, one in found.items()}


def _read(bench: Bench, point: Extended) -> Apart | None:
    """What a point reads on the finer mesh [K]; None where there can be no such temperatures."""
    try:
        return finer_runs(bench, point)
    except InputError:
        return None


def _compared(
    apart: tuple[Float[np.ndarray, "frames samples"], Float[np.ndarray, "frames samples"]],
    run: Run,
    time: Float[np.ndarray, " frames"],
) -> HeldOut:
    """Differences of one run before and after [K], at its times [s]; NaN where nothing is read."""
    run = with_noise(run, noise_left(run, apart[1], time))
    both = [_staying_off(each, run) for each in apart]
    apart_there = Differences(time, run.recording.points, *both)
    before, after = (float(np.sqrt(np.nanmean(each**2))) for each in both)
    told, doubt = run.noise_of_readings(), variance_error(run.recording)
    count, size = np.isfinite(both[0]).sum(0), told.fluctuation() ** 2
    # What quiet frames leave open of a sample's constant error is in all of its differences.
    stays = left_open(run)
    squares = np.stack([*(np.nansum(each**2, 0) for each in both), (size + stays) * count])
    whole = squares.sum(1)
    noise = float(np.sqrt(whole[2] / count.sum()))
    # Beyond the scatter of noise alone there is nothing to close.
    follow = (1 + told.correlation**2) / (1 - told.correlation**2)
    scatter = np.sqrt(2 * (follow * size**2 * count.sum() + np.sum((stays * count) ** 2)))
    if whole[0] - whole[2] <= 5 * scatter:
        return HeldOut(before, after, noise, None, None, doubt, apart_there)
    ends = closed_interval(squares, doubt)
    return HeldOut(before, after, noise, float(closed(whole)), ends, doubt, apart_there)


def closed(squares: Float[np.ndarray, "3 *draws"]) -> Float[np.ndarray, "*draws"]:
    """Share closed [1] of squares before, after, and of noise alone [K2]."""
    before, after, noise = squares
    return np.asarray(1 - (after - noise) / (before - noise))


def closed_interval(
    squares: Float[np.ndarray, "3 samples"], doubt: float
) -> tuple[float, float] | None:
    """In which 95 % of the shares closed [1] lie, samples drawn anew with all their readings.

    `squares`: of each sample before and after, and of noise alone [K2]; `doubt`: deviation of the
    variance of noise as it was told, over that variance, drawn as well [1]. None with too few
    samples.

    Source: Efron and Tibshirani, An Introduction to the Bootstrap (1993), chapter 13, percentiles.
    """
    samples = squares.shape[1]
    if samples < _FEW:
        return None
    random = np.random.default_rng(0)
    sums = squares[:, random.integers(samples, size=(_DRAWS, samples))].sum(2)
    sums[2] *= 1 + doubt * random.standard_normal(_DRAWS)
    shares = closed(sums)
    low, high = np.quantile(shares, [0.025, 0.975])
    return float(low), float(high)


def _staying_off(
    apart: Float[np.ndarray, "frames samples"], run: Run
) -> Float[np.ndarray, "frames samples"]:
    """Differences [K] without the constant errors of samples."""
    return apart + staying(-apart, run)
