"""Noise of runs without quiet frames from where a fit ended, and a model that counts with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
from jaxtyping import Int

from thermo.inverse._case import Case, one_run, pad_errors, pile, reading_errors
from thermo.inverse._defect import with_shared
from thermo.inverse._log_model import LogModel
from thermo.inverse._objective import Objective
from thermo.inverse._run_fit import differences
from thermo.observe import ResidualNoise, Run, Scene, residual_noise


def residual_noises(model: LogModel, scene: Scene) -> dict[str, ResidualNoise]:
    """By run without quiet frames, its noise [K] from the residual at the model's first values.

    Ask it where a fit ended. Runs whose residual is too short for that are left out.

    Arguments: `scene`: the one that the model was made of.
    """
    objective, found = model.objective, {}
    apart = iter(differences(objective, jnp.asarray(model(model.first)[0])))
    numbers = iter(objective.sequence)
    for case in objective.cases:
        for row in range(len(case.trust)):
            run, residual = scene.runs[model.runs[next(numbers)]], np.asarray(next(apart))
            frames = _frames(run, case, row)
            known = np.where(np.asarray(case.used[row]) > 0, residual, np.nan)
            known = known[: len(frames), : len(run.recording.points)]
            if not run.recording.knows_quiet():
                noise = residual_noise(run.recording, known, frames)
                found |= {} if noise is None else {run.name: noise}
    return found


def with_noise(
    model: LogModel, scene: Scene, noise: Mapping[str, ResidualNoise], *, model_error: float
) -> LogModel:
    """The model whose readings have the errors of a noise [K], in the runs that it names.

    Arguments: `scene` and `model_error` [K]: those that the model was made of.
    """
    if not noise:
        return model
    runs = [scene.runs[name] for name in model.runs]
    objective = _with_noise(model.objective, runs, noise, model_error)
    if any(np.any(np.asarray(case.shared)) for case in objective.cases):
        objective = with_shared(objective)
    return replace(model, objective=objective)


def _with_noise(
    objective: Objective, runs: Sequence[Run], noise: Mapping[str, ResidualNoise], error: float
) -> Objective:
    numbers, cases = iter(objective.sequence), []
    for case in objective.cases:
        rows = []
        for row in range(len(case.trust)):
            run = runs[next(numbers)]
            errors = one_run(case.errors, row)
            if run.name in noise:
                level, frames = noise[run.name].noise, _frames(run, case, row)
                fresh = reading_errors(run, level, frames, model_error=error)
                errors = pad_errors(fresh, *case.data.shape[1:])
            rows.append(errors)
        cases.append(replace(case, errors=pile(rows)))
    return replace(objective, cases=tuple(cases))


def _frames(run: Run, case: Case, row: int) -> Int[np.ndarray, " frames"]:
    """Numbers of the recording's frames that a case holds, without those that fill it up."""
    time = np.asarray(case.time[row])
    count = 1 + int(np.argmax(time >= time[-1]))
    return np.searchsorted(run.recording.time, time[:count] - 1e-9)
