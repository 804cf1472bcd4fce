"""Runs that were not fitted: what a point reads there, against what was recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np

from thermo.discover._bench import Bench, finer_runs
from thermo.discover._extended import Extended, whitened
from thermo.discover._verdict import HeldOut
from thermo.inverse import Case, Objective, coarse_tangents, lay_out
from thermo.observe import estimate_noise


def held_out(bench: Bench, stated: Extended, extended: Extended) -> Mapping[str, HeldOut]:
    """Both points on the finer mesh, on the runs that the scene holds out [K]."""
    scene = bench.task.scene
    runs = tuple(run for run in scene.runs.values() if run.held_out)
    if not runs:
        return {}
    task = replace(bench.task, runs=runs)
    ready = replace(lay_out(task, bench.ready.mesh, bench.ready.stated), fields=bench.ready.fields)
    like = coarse_tangents(task, ready)
    there = replace(bench, task=task, ready=ready, coarse=like)
    both = [finer_runs(there, point) for point in (stated, extended)]
    found, order = {}, iter(like.sequence)
    for number, case in enumerate(like.cases):
        apart = [np.nan_to_num(np.asarray(read[number]) - np.asarray(case.data)) for read in both]
        for row in range(len(case.data)):
            one = replace(like, cases=(_only(case, row),))
            pair = (apart[0][row : row + 1], apart[1][row : row + 1])
            run = runs[next(order)]
            found[run.name] = _compared(one, pair, estimate_noise(run.recording).white)
    return found


def _compared(one: Objective, apart: tuple[np.ndarray, np.ndarray], noise: float) -> HeldOut:
    """Differences of one run before and after [K]."""
    used = np.asarray(one.cases[0].used) > 0
    before, after = (float(np.sqrt(np.mean(each[used] ** 2))) for each in apart)
    told, rest = (
        float(np.sum(np.asarray(whitened(one, [jnp.asarray(each)])) ** 2)) for each in apart
    )
    count = float(used.sum())
    # Beyond the scatter of noise alone there is nothing to close.
    beyond = told - count > 5 * np.sqrt(2 * count)
    return HeldOut(before, after, noise, 1 - (rest - count) / (told - count) if beyond else None)


def _only(case: Case, row: int) -> Case:
    return jax.tree.map(lambda leaf: leaf[row : row + 1], case)
