"""Noise of runs without quiet frames, as what a fit leaves between neighbours tells it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from jaxtyping import Float

from thermo.discover._met import met_runs
from thermo.discover._standing import Standing, fitted
from thermo.inverse import coarse_tangents, with_defects, with_remainders
from thermo.observe import ResidualNoise, Run, residual_noise

_LEARNT: Final = (
    "{} has no quiet frames. Its noise is told by what the stated model leaves between neighbours: "
    "{:.2g} K a reading, {:.0f} % of which stay until the next frame. {}"
)
_EXACT: Final = (
    "{} without quiet frames and `constant_error`: samples are taken as exact. What each reads "
    "wrong all the time would look like an effect; `constant_error` of a run allows for it."
)


def with_learnt_noise(standing: Standing) -> tuple[Standing, list[str]]:
    """Fitted anew with the noise [K] that it leaves, where no quiet frames tell it; and remarks.

    What samples are off by all the time, and what of noise stays from frame to frame, is seen in
    no second difference of a record, and would be taken for an effect.
    """
    bench, found = standing.bench, met_runs(standing)
    told = [
        noise_left(run, found[run.name].simulated - found[run.name].measured, found[run.name].time)
        for run in bench.task.runs
    ]
    pairs = list(zip(bench.task.runs, told, strict=True))
    remarks = [
        _LEARNT.format(run.name, one.noise.white, 100 * one.noise.correlation, one.words())
        for run, one in pairs
        if one is not None
    ]
    if not remarks:
        return standing, []
    task = replace(bench.task, runs=tuple(with_noise(*pair) for pair in pairs))
    there = bench.coarse.cases
    coarse = with_defects(coarse_tangents(task, bench.ready), [one.defect for one in there])
    rest = [one.remainder for one in there if one.remainder is not None]
    coarse = with_remainders(coarse, rest)
    bench = replace(bench, task=task, coarse=coarse)
    return fitted(replace(standing, bench=bench), times=0), remarks


def noise_left(
    run: Run, apart: Float[np.ndarray, "frames samples"], time: Float[np.ndarray, " frames"]
) -> ResidualNoise | None:
    """The noise [K] of a run that tells none, from differences [K] at its times [s].

    None where quiet frames tell it, or where there is too little of it.
    """
    if run.recording.knows_quiet() or run.noise is not None:
        return None
    return residual_noise(run.recording, apart, np.searchsorted(run.recording.time, time - 1e-9))


def with_noise(run: Run, told: ResidualNoise | None) -> Run:
    """The run with what is told of its noise [K]."""
    return run if told is None else replace(run, noise=told.noise)


def taken_as_exact(runs: Sequence[Run]) -> list[str]:
    """What to say of runs of which nothing tells what their samples read wrong all the time."""
    names = [
        run.name
        for run in runs
        if not (run.recording.knows_quiet() or run.constant_error or run.noise)
    ]
    return [_EXACT.format(", ".join(names))] if names else []
