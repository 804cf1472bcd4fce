"""What `thermo identify` fits anew where a fit ended, as far as its time goes."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from typing import Any, final

import numpy as np

from thermo.app._time_limit import OutOfTime, TimeLimit
from thermo.identify import Basins, Profile, basins, profile
from thermo.inverse import LogModel, Prior, log_model, residual_noises, with_noise
from thermo.observe import ResidualNoise, Scene


@final
@dataclass(frozen=True)
class Wanted:
    """`budget` [s]; `starts`: factors on the values found [1]; `draws` of the noise; `seed`."""

    budget: float
    starts: tuple[float, ...]
    draws: int
    seed: int


@final
@dataclass
class Refits:
    """Profiles by unknown, where other starts end, and in words what was not made.

    - `misfit`: root mean square of the whitened residual where the fit ended [1], about 1 where
      simulation and readings agree.
    - `defect`: what cells and steps make wrong, by run, (frames, samples) [K].
    - `noise`: of runs without quiet frames, from the residual where the fit ended.
    """

    misfit: float | None = None
    defect: dict[str, np.ndarray] = field(default_factory=dict)
    noise: dict[str, ResidualNoise] = field(default_factory=dict)
    profiles: dict[str, Profile] = field(default_factory=dict)
    basins: Basins | None = None
    left_out: list[str] = field(default_factory=list)


def refit(
    scene: Scene, asked: dict[str, Any], prior: dict[str, float], model_error: float, wanted: Wanted
) -> Refits:
    """Profiles of all unknowns and fits from other starts; nothing is simulated once time is spent.

    Arguments: `asked`, `prior` and `model_error` [K] as for `thermo.inverse.log_model`.
    """
    words = "measuring what the fit's cells and steps make wrong; then profiles and fits from other"
    print(words, f"starts, for {wanted.budget:g} s at most", file=sys.stderr)
    model = log_model(scene, prior=Prior(spread=prior), model_error=model_error, **asked)
    # What is compiled by the first call is not counted.
    residual, _ = model(model.first)
    used = sum(float(case.used.sum()) for case in model.objective.cases)
    misfit = float(np.sqrt(np.sum(residual**2) / used))
    # What the residual is beyond the noise that was known before it has to show in the misfit.
    noise = residual_noises(model, scene)
    model = with_noise(model, scene, noise, model_error=model_error)
    found = Refits(misfit=misfit, defect=model.defect(), noise=noise)
    limit = TimeLimit(wanted.budget)
    # Profiles say whether an interval holds, and are first where time is for one of both.
    _profiles(model, limit, found)
    _basins(model, wanted, limit, found)
    return found


def _basins(model: LogModel, wanted: Wanted, limit: TimeLimit, found: Refits) -> None:
    if not wanted.starts:
        found.left_out.append("Basins and scatter: no starts were given.")
        return
    if wanted.draws == 0:
        found.left_out.append("Scatter over draws of the noise: draws is 0.")
    low, high = model.bounds.T
    starts = [np.clip(model.first + np.log(factor), low, high) for factor in (1.0, *wanted.starts)]
    asked = {"bounds": model.bounds, "draws": wanted.draws, "seed": wanted.seed}
    try:
        found.basins = basins(limit.watched(model), np.array(starts), **asked)
    except OutOfTime:
        found.left_out.append(f"Basins: {limit.words()}.")


def _profiles(model: LogModel, limit: TimeLimit, found: Refits) -> None:
    for place, name in enumerate(model.names):
        try:
            made = profile(limit.watched(model), model.first, place, bounds=model.bounds)
        except OutOfTime:
            missed = ", ".join(model.names[place:])
            found.left_out.append(f"Profiles of {missed}: {limit.words()}.")
            return
        found.profiles[name] = made
        print(f"profile of {name}: {made.kind}", file=sys.stderr)
