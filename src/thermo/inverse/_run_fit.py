"""How each run was met: simulated beside measured."""

from __future__ import annotations

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from thermo.inverse._estimate import RunFit
from thermo.inverse._minimise import Fit
from thermo.inverse._objective import Objective, residual
from thermo.observe import Run, estimate_noise
from thermo.physics import TimeGrid


def _differences(
    objective: Objective, whitened: Float[Array, " all"]
) -> list[Float[np.ndarray, "frames samples"]]:
    """Simulated less measured temperatures [K] of each run, NaN where nothing was measured."""
    result, begin = [], 0
    for case in objective.cases:
        size = case.data.size
        part = np.asarray(whitened[begin : begin + size]).reshape(case.data.shape)
        weight = np.asarray(case.weight)
        result += list(np.where(weight > 0, part / np.where(weight > 0, weight, 1), np.nan))
        begin += size
    return result


def run_fits(fit: Fit, runs: tuple[Run, ...], grids: dict[str, TimeGrid]) -> dict[str, RunFit]:
    """Temperatures [K] of each run with the fitted fields, at the frames of its grid [s]."""
    objective = fit.objective
    whitened = fit.residual
    if whitened is None:
        whitened = eqx.filter_jit(residual)(objective, fit.parameters)
    apart = _differences(objective, whitened)
    measured = [np.asarray(one) for case in objective.cases for one in case.data]
    heaviest = [float(np.max(one)) for case in objective.cases for one in case.weight]
    result = {}
    for number, run in enumerate(runs):
        place = objective.sequence.index(number)
        frames, samples = len(grids[run.name].frame_time), len(run.recording.points)
        difference = apart[place][:frames, :samples]
        simulated = measured[place][:frames, :samples] + difference
        result[run.name] = RunFit(
            rmse=float(np.sqrt(np.nanmean(difference**2))),
            noise=estimate_noise(run.recording).white,
            deviation=1 / heaviest[place],
            time=np.asarray(grids[run.name].frame_time),
            points=run.recording.points,
            measured=np.where(np.isnan(difference), np.nan, measured[place][:frames, :samples]),
            simulated=simulated,
        )
    return result
