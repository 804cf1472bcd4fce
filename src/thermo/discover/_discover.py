"""Find where simulation and measurement disagree, name what is missing, and prove it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from thermo._say import Say
from thermo.discover._aliases import aliases
from thermo.discover._allowance import NOTHING_ALLOWED, allowance
from thermo.discover._bench import (
    Apart,
    Bench,
    corrected,
    finer_runs,
    read_there,
    set_up,
    usual_errors,
)
from thermo.discover._candidate import Candidate
from thermo.discover._cautions import cautions, samples_off
from thermo.discover._descent import Ended
from thermo.discover._learnt_noise import taken_as_exact, with_learnt_noise
from thermo.discover._library import Setting, library, setting_of
from thermo.discover._memory import memory_of
from thermo.discover._met import estimate_of
from thermo.discover._misfit import Misfit, misfits
from thermo.discover._pace import MEASURE, Pace
from thermo.discover._parameters import parameter_intervals, parameters
from thermo.discover._path import SearchPath, search
from thermo.discover._power import powers
from thermo.discover._registered import registered
from thermo.discover._rounds import candidacies
from thermo.discover._scores import ScoreTable
from thermo.discover._softening import blocks, error_columns, stamp_columns
from thermo.discover._standing import Standing, at_work, fitted
from thermo.discover._told_apart import told_apart
from thermo.discover._trace import traces
from thermo.discover._verdict import HeldOut, Verdict
from thermo.errors import InputError
from thermo.inverse import (
    Meshing,
    Prior,
    Stepping,
    Uniform,
    defect_sizes,
    unfitted,
    with_defects,
)
from thermo.observe import Scene

FRAMES = 300
"""Frames of a run that are compared [1], as a slow sensor shows from frame to frame."""

NODES = 6000
"""About the most nodes of the mesh [1], whose errors are measured and taken off."""

_LEFT_OUT: Final = (
    "Not looked for: {}. An effect that is left out may be named as one that reads like it."
)
_BLIND: Final = "Readings of these runs do not change with {}: nothing is known of it."
_UNPROVED: Final = "No run is held out, so that nothing is proved."


def discover(
    data: Scene | str | Path,
    *,
    runs: tuple[str, ...] | None = None,
    unknown: tuple[str, ...] | None = None,
    prior: Prior | None = None,
    stepping: Stepping | None = None,
    meshing: Meshing | None = None,
    initial: dict[str, float] | None = None,
    model_error: float = 0.005,
    candidates: Callable[[Setting], tuple[Candidate, ...]] = registered,
    checkpoint: Path | None = None,
    say: Say = lambda words: None,
) -> Verdict:
    """Which effect is missing in what a scene states, if any is.

    One value of each unknown is fitted; residuals are compared with noise; every candidate is
    scored at strength zero; the credible ones are refitted, with their places; the best is put to
    work, and the search goes on from there until nothing is missing. Its thresholds are set so that
    noise alone passes them in 5 % of cases.

    Arguments as for `invert`, `initial` by quantity [SI] and `model_error` [K] among them. Held-out
    runs are predicted only. And:

    - `candidates`: from what is known of body and runs [SI] to all effects that may be missing,
      each of another name and of strength zero; the library and what is registered by default.
    - `checkpoint`: folder for what is finished, from which an interrupted search goes on to the
      same verdict, bit by bit; `forget` it once the verdict is safe.
    - `say`: is told what is being done, and about how long what is known of a round still takes.

    Raises `InputError` as `invert` does, and where two candidates have one name.

    Source: Rao, Proc. Camb. Phil. Soc. 44 (1948) 50, the scores; McCullagh and Nelder, Generalized
    Linear Models (1989), section 9.2, how rivals are compared.
    """
    started = time.monotonic()
    task = unfitted(
        data, runs, unknown, Uniform(), prior or Prior(), stepping or Stepping(most_frames=FRAMES),
        meshing or Meshing(max_nodes=NODES), initial, model_error=model_error,
    )  # fmt: skip
    say("meshing")
    bench = set_up(task)
    setting = setting_of(task.scene, task.runs, bench.ready.mesh, task.names)
    every = candidates(setting)
    _check_names(every)
    memory = memory_of(checkpoint, every)
    bench, pace = replace(bench, memory=memory), Pace(say, memory.spared)
    begun, left, learnt = _begin(bench, every, pace)
    cells = rough(_sizes(begun, left), _noise(begun))
    path = search(begun, tuple(one for one in every if one.card.law), pace, rough=bool(cells))
    path, proof = told_apart(path, pace)
    if path.word != "no_gap":
        learnt = learnt + taken_as_exact(begun.bench.task.runs)
    bench = begun.bench
    off = samples_off(bench.task.runs, bench.ready.mesh)
    told = learnt + off + left_out(every, setting) + blind_to(path.table)
    path = replace(path, remarks=path.remarks + cells + told)
    return _answer(path, proof, left, time.monotonic() - started)


def _answer(path: SearchPath, proof: Mapping[str, HeldOut], left: Apart, seconds: float) -> Verdict:
    """A search of so many seconds [s] as a verdict; `left`: see `_sizes` [K]."""
    begun = path.begun
    last = path.standing if path.word in ("named", "inseparable") else begun
    named = {one.effect.card.name for one in path.rounds}
    found = path.rounds if path.word in ("named", "inseparable") else []
    told = cautions(found, begun.bench.task.runs, proof, path.standing.chance())
    return Verdict(
        verdict=path.word,
        rounds=path.rounds,
        candidates=candidacies(path.table, {}, 1.0, {}),
        threshold=path.table.threshold,
        held_out=proof,
        missed={name: one for name, one in powers(path.table).items() if name not in named},
        cells=_sizes(begun, left),
        noise=_noise(begun),
        parameters=parameters(begun, path.standing),
        intervals={} if path.word == "none_of_mine" else parameter_intervals(path.standing),
        alias=aliases(path.table),
        calibration=path.calibrated,
        misfits=(_misfits(begun), _misfits(path.standing)),
        traces=(traces(begun), traces(path.standing)),
        omnibus=(begun.chance(), path.standing.chance()),
        stated=estimate_of(begun, seconds),
        extended=estimate_of(last, seconds),
        additions=at_work(last),
        remarks=path.remarks + told + ([] if proof else [_UNPROVED]),
    )


def _noise(begun: Standing) -> dict[str, float]:
    """Of a reading, by run [K]."""
    return {run.name: run.noise_of_readings().fluctuation() for run in begun.bench.task.runs}


def rough(cells: Mapping[str, float], noise: Mapping[str, float]) -> list[str]:
    """What to say of runs on which cells and steps make more wrong than noise does [K]."""
    return [
        f"On {run} a fit's usual cells and steps are wrong by {wrong:.2g} K, more than the noise, "
        f"{noise[run]:.2g} K. That was measured on smaller ones and taken off, but for what these "
        "are wrong by themselves. A larger mesh.cells_per_depth, 1 by default, leaves less."
        for run, wrong in cells.items()
        if wrong > noise[run]
    ]


def left_out(every: tuple[Candidate, ...], setting: Setting) -> list[str]:
    """What to say of kinds of the library that were not looked for."""
    names = {one.card.name for one in every}
    missing = [one.card.name for one in library(setting) if one.card.name not in names]
    return [_LEFT_OUT.format(", ".join(missing))] if missing else []


def blind_to(table: ScoreTable) -> list[str]:
    """What to say of kinds of which no part shows in the readings, a lamp's where none is lit."""
    seen = {one.name() for one in table.scores}
    missing = dict.fromkeys(one.card.name for one in table.unseen if one.card.name not in seen)
    return [_BLIND.format(", ".join(missing))] if missing else []


def _misfits(standing: Standing) -> Mapping[str, Misfit]:
    return misfits(standing.allowed.runs, standing.ended.residual)


def _check_names(every: tuple[Candidate, ...]) -> None:
    names = [one.card.name for one in every]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice or not names:
        raise InputError(
            "two candidates have one name" if twice else "there is no candidate",
            where="candidates", value=", ".join(twice) or "none",
            limit="one or more, each of a name of its own",
            remedy="give the card of one of them another name",
        )  # fmt: skip


def _begin(
    bench: Bench, every: tuple[Candidate, ...], pace: Pace
) -> tuple[Standing, Apart, list[str]]:
    """The stated model fitted, what a fit's usual cells and steps make wrong there [K], remarks."""
    pace.step("fitting what is stated")
    # Laws make another program, and stand in the point only where one of them is at work.
    point = bench.first(tuple(one for one in every if not one.card.law))
    first = {one.card.name: one for one in every}
    nothing = Ended(point, np.zeros(0), np.zeros((0, 0)))
    standing = Standing(bench, first, point, (), nothing, NOTHING_ALLOWED)
    standing = fitted(standing, times=0)
    pace.step("measuring what cells and steps make wrong", MEASURE)
    standing, remarks = with_learnt_noise(fitted(standing, times=1))
    pace.step("measuring what is left of that")
    # Once more where that ended; the same finer runs say what a fit's usual cells make wrong.
    wanted = finer_runs(standing.bench, standing.point)
    left = usual_errors(standing.bench, standing.point, wanted)
    bench = corrected(standing.bench, standing.point, wanted)
    runs = blocks(bench.coarse, bench.task, left)
    count = len(standing.ended.residual)
    small = replace(standing.point, candidates=())
    errors = (
        error_columns(runs, bench.coarse, left, count),
        stamp_columns(runs, bench.coarse, read_there(bench.memory, bench.coarse, small), count),
    )
    allowed = allowance(runs, np.concatenate(errors, 1))
    return fitted(replace(standing, bench=bench, allowed=allowed), times=0), left, remarks


def _sizes(begun: Standing, left: Apart) -> dict[str, float]:
    """Root mean square of what a fit's usual cells and steps make wrong, by run [K]."""
    found = defect_sizes(with_defects(begun.bench.coarse, left))
    return {begun.bench.task.runs[number].name: size for number, size in found.items()}
