"""A standing of the search as an estimate: its fields, and how it meets each run."""

from __future__ import annotations

from typing import Final

import numpy as np

from thermo.discover._bench import read_there, steps_for
from thermo.discover._standing import Standing, with_few_places
from thermo.inverse import Estimate, RunFit, defect_sizes, recovered, staying, with_fields

_RESOLVED: Final = "What cells and steps make wrong was measured on a finer mesh and taken off."


def met_runs(standing: Standing) -> dict[str, RunFit]:
    """What is read and what was measured [K] in each run, constant errors of samples taken off."""
    # As in a fit, whose program of readings is there already.
    point = with_few_places(standing)[0].point
    coarse, grids = steps_for(standing.bench.coarse, point), standing.bench.ready.grids
    sizes, order = defect_sizes(coarse), iter(coarse.sequence)
    there = read_there(standing.bench.memory, coarse, point)
    found = {}
    for case, group in zip(coarse.cases, there, strict=True):
        every = (np.asarray(group), np.asarray(case.data), np.asarray(case.weight()))
        for read, data, weight in zip(*every, strict=True):
            number = next(order)
            run = standing.bench.task.runs[number]
            time = np.asarray(grids[run.name].frame_time)
            here = slice(len(time)), slice(len(run.recording.points))
            measured = np.where(weight > 0, data, np.nan)[here]
            measured = measured - staying(measured - read[here], run)
            found[run.name] = RunFit(
                rmse=float(np.sqrt(np.nanmean((read[here] - measured) ** 2))),
                noise=run.noise_of_readings().fluctuation(),
                defect=sizes[number],
                deviation=1 / float(weight.max()),
                time=time,
                points=run.recording.points,
                measured=measured,
                simulated=read[here],
            )
    return found


def estimate_of(standing: Standing, seconds: float) -> Estimate:
    """The fields [SI] and runs [K] of a standing, found in so many seconds [s]."""
    bench = standing.bench
    return Estimate(
        mesh=bench.ready.mesh,
        order=bench.task.meshing.order,
        stated=bench.ready.stated,
        fields=recovered(with_fields(bench.coarse, standing.point.fields)),
        runs=met_runs(standing),
        history=[],
        success=True,
        seconds=seconds,
        resolution=_RESOLVED,
        smoothness={},
    )
