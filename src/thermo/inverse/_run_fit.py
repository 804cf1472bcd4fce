"""How each run was met: simulated beside measured."""

from __future__ import annotations

import equinox as eqx
import jax
import numpy as np

from thermo.fields import AbstractField
from thermo.inverse._estimate import RunFit
from thermo.inverse._minimise import Fit
from thermo.inverse._objective import Objective, case_temperatures, with_fields
from thermo.observe import Run
from thermo.physics import TimeGrid


@eqx.filter_jit
def _temperatures(objective: Objective, fields: dict[str, AbstractField]) -> list[jax.Array]:
    return [
        jax.lax.map(lambda one: case_temperatures(objective, fields, one), case)
        for case in objective.cases
    ]


def run_fits(
    objective: Objective, fit: Fit, runs: tuple[Run, ...], grids: dict[str, TimeGrid]
) -> dict[str, RunFit]:
    """Temperatures [K] of each run with the fitted fields, at the frames of its grid [s]."""
    fields = with_fields(objective, fit.parameters)
    simulated = [np.asarray(one) for group in _temperatures(objective, fields) for one in group]
    measured = [np.asarray(one) for case in objective.cases for one in case.data]
    weights = [np.asarray(one) for case in objective.cases for one in case.weight]
    result = {}
    for number, run in enumerate(runs):
        place = objective.sequence.index(number)
        frames, samples = len(grids[run.name].frame_time), len(run.recording.points)
        cut = (slice(0, frames), slice(0, samples))
        valid = weights[place][cut] > 0
        data = np.where(valid, measured[place][cut], np.nan)
        here = simulated[place][cut]
        result[run.name] = RunFit(
            rmse=float(np.sqrt(np.nanmean((here - data) ** 2))),
            time=np.asarray(grids[run.name].frame_time),
            points=run.recording.points,
            measured=data,
            simulated=here,
        )
    return result
