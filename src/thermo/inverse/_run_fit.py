"""How each run was met: simulated beside measured."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo._compiled import program
from thermo.inverse._defect import defect_sizes
from thermo.inverse._estimate import RunFit
from thermo.inverse._minimise import Fit
from thermo.inverse._objective import Objective, residual, run_parts
from thermo.inverse._reading_errors import colour, with_again
from thermo.inverse._staying import staying
from thermo.observe import Run
from thermo.physics import TimeGrid


def run_fits(fit: Fit, runs: tuple[Run, ...], grids: dict[str, TimeGrid]) -> dict[str, RunFit]:
    """Temperatures [K] of each run with the fitted fields, at the frames of its grid [s].

    What is measured stands without each sample's constant error, from quiet frames or, where a run
    states how large it may be, as the fit tells it.
    """
    objective = fit.objective
    whitened = fit.residual
    if whitened is None:
        whitened = program(residual)(objective, fit.parameters)
    apart = differences(objective, jnp.asarray(whitened))
    measured = [np.asarray(one) for case in objective.cases for one in case.data]
    result, defect = {}, defect_sizes(objective)
    for place, (number, _, weight) in enumerate(run_parts(objective)):
        run = runs[number]
        frames, samples = len(grids[run.name].frame_time), len(run.recording.points)
        # NaN where nothing was measured.
        difference = np.where(weight > 0, apart[place], np.nan)[:frames, :samples]
        found = measured[place][:frames, :samples]
        stays = staying(-difference, run)
        found, difference = found - stays, difference + stays
        result[run.name] = RunFit(
            rmse=float(np.sqrt(np.nanmean(difference**2))),
            noise=run.noise_of_readings().fluctuation(),
            defect=defect[number],
            deviation=1 / float(weight.max()),
            time=np.asarray(grids[run.name].frame_time),
            points=run.recording.points,
            measured=np.where(np.isnan(difference), np.nan, found),
            simulated=found + difference,
        )
    return {run.name: result[run.name] for run in runs}


@eqx.filter_jit
def differences(
    objective: Objective, whitened: Float[Array, " all"]
) -> list[Float[Array, "frames samples"]]:
    """Simulated less measured temperatures of each run [K] from the whitened residual [1]."""
    found, begin = [], 0
    for case in objective.cases:
        part = whitened[begin : begin + case.data.size].reshape(case.data.shape)
        white = jax.vmap(with_again)(case.shared, part / case.trust[:, None, None])
        found += list(jax.vmap(colour)(case.errors, case.used, white))
        begin += case.data.size
    return found
