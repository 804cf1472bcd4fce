"""`thermo identify`: what runs tell of the unknowns, before a fit or where one ended."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from thermo import inverse
from thermo.app._configuration import (
    build_field,
    build_meshing,
    build_stepping,
    given,
    names,
    number,
)
from thermo.app._fitted import Fitted, read_fitted
from thermo.errors import InputError
from thermo.identify import Profile, identifiability, profile
from thermo.inverse import SCALES, Prior, Uniform
from thermo.observe import Scene, read_scene
from thermo.report import (
    identifiability_record,
    identifiability_table,
    require_writable,
    write_identifiability,
)

NO_BASINS = (
    "Basins: fits from other first values and seeds are `thermo invert -m init=... seed=...`, and "
    "`thermo ensemble` says how far they agree."
)


class _OutOfTime(Exception):
    """The time for profiles is spent."""


def identify(settings: Mapping[str, Any]) -> None:
    """Ask what the data identify, and leave `identifiability.json` and a page rendered from it."""
    begun = time.monotonic()
    out = Path(settings["out"])
    fitted = None if settings["estimate"] is None else read_fitted(Path(settings["estimate"]))
    asked = _asked(settings, fitted)
    choice = build_field(settings["field"])
    wanted = number(settings, "wanted", above=0.0)
    model_error = number(settings, "model_error", above=0.0)
    budget = number(settings, "budget")
    scene = read_scene(Path(settings["data"]))
    every = asked["unknown"] or scene.unknown
    scales = tuple(name for name in every if name in SCALES)
    asked["unknown"] = tuple(name for name in every if name not in SCALES)
    prior = _prior(settings, scene, every)
    require_writable(out)
    print("meshing and compiling come first", file=sys.stderr)
    at = inverse.sensitivity(scene, choice=choice, scales=scales, **asked)
    found = identifiability(at, prior=prior, model_error=model_error, wanted=wanted)
    runs = [scene.runs[name] for name in at.slopes]
    profiles: dict[str, Profile] = {}
    left_out = [NO_BASINS]

    def leave() -> dict[str, Any]:
        record = identifiability_record(found, at, runs, profiles, left_out)
        record |= {"seconds": time.monotonic() - begun, "model_error": model_error}
        record |= {"before_fit": fitted is None, "configuration": settings}
        title = f"{scene.object}: what {', '.join(at.slopes)} tell"
        write_identifiability(out, record, title)
        return record

    why = _no_profiles(fitted, scales, choice, budget)
    if why:
        left_out.append(f"Profiles: {why}.")
    record = leave()
    if not why:
        left_out += _profile_all(scene, asked, prior, model_error, budget, profiles)
        record = leave()
    told = "\n".join(record["sentences"])
    print(f"{identifiability_table(record)}\n\n{told}\n\n{out / 'identifiability.html'}")


def _asked(settings: Mapping[str, Any], fitted: Fitted | None) -> dict[str, Any]:
    """What `sensitivity` and `log_model` are asked [SI]."""
    runs, unknown = names(settings["runs"], "runs"), names(settings["unknown"], "unknown")
    initial = given(settings["initial"], "initial.")
    if fitted is not None:
        runs, unknown = runs or fitted.runs, unknown or fitted.unknown
        initial = fitted.values | initial
    return {
        "runs": runs,
        "unknown": unknown,
        "initial": initial,
        "stepping": build_stepping(settings["integrator"]),
        "meshing": build_meshing(settings["mesh"]),
    }


def _prior(settings: Mapping[str, Any], scene: Scene, unknown: tuple[str, ...]) -> dict[str, float]:
    """Standard deviations of log(value) [1], the scene's and then those of the command line."""
    spread = given(settings["spread"], "spread.")
    for name, value in spread.items():
        if name not in unknown or value <= 0:
            raise InputError(
                "this spread cannot be", where=f"spread.{name}", value=value,
                limit=f"a number above 0 for one of the unknowns: {', '.join(unknown)}",
                remedy="give the standard deviation of the logarithm, 0.1 for 10 %",
            )  # fmt: skip
    return {name: value for name, value in scene.prior.items() if name in unknown} | spread


def _no_profiles(fitted: Fitted | None, scales: tuple[str, ...], choice: Any, budget: float) -> str:
    """Why there are no profiles, nothing where there are."""
    if fitted is None:
        return "they take a fit, give estimate=DIR"
    if budget <= 0:
        return "budget is 0"
    if scales:
        return f"{', '.join(scales)} cannot be fitted yet"
    if not isinstance(choice, Uniform):
        return "only values of the whole body have them"
    return ""


def _profile_all(
    scene: Scene,
    asked: dict[str, Any],
    prior: dict[str, float],
    model_error: float,
    budget: float,
    profiles: dict[str, Profile],
) -> list[str]:
    """Profiles of all unknowns as far as the time [s] goes; what was not reached, in words."""
    model = inverse.log_model(scene, prior=Prior(spread=prior), model_error=model_error, **asked)
    begun = time.monotonic()

    def on_point(count: int) -> None:
        del count
        if time.monotonic() - begun > budget:
            raise _OutOfTime

    for place, name in enumerate(model.names):
        try:
            profiles[name] = profile(
                model, model.first, place, bounds=model.bounds, on_point=on_point
            )
        except _OutOfTime:
            missed = ", ".join(model.names[place:])
            return [f"Profiles of {missed}: {budget:g} s were spent, raise budget."]
        print(f"profile of {name}: {profiles[name].kind}", file=sys.stderr)
    return []
