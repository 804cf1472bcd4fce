"""`thermo identify`: what runs tell of the unknowns, before a fit or where one ended."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from thermo import inverse
from thermo.app._analysis import Analysis
from thermo.app._candidates import build_candidates
from thermo.app._configuration import (
    build_field,
    build_meshing,
    build_stepping,
    given,
    names,
    number,
)
from thermo.app._fields_left import FieldsLeft, WantedOfFields, fields_left
from thermo.app._fitted import Fitted, check_same_body, read_fitted
from thermo.app._refits import Refits, Wanted, refit
from thermo.app._regions import build_regions
from thermo.app._scene import scene_of
from thermo.errors import InputError
from thermo.fields import QUANTITIES
from thermo.identify import unknowns_of
from thermo.inverse import SCALES, Uniform
from thermo.observe import Run, Scene
from thermo.report import (
    identifiability_table,
    require_writable,
    write_fields_left,
)


def identify(settings: Mapping[str, Any]) -> None:
    """Ask what the data identify, and leave `identifiability.json` and a page rendered from it."""
    begun = time.monotonic()
    out = Path(settings["out"])
    estimate = None if settings["estimate"] is None else Path(settings["estimate"])
    fitted = None if estimate is None else read_fitted(estimate)
    asked = _asked(settings, fitted)
    choice = build_field(settings["field"])
    wanted = number(settings, "wanted", above=0.0)
    model_error = number(settings, "model_error", above=0.0)
    refits, of_fields = _wanted(settings, fitted)
    scene, _ = scene_of(settings, drop=fitted is not None and fitted.dropped)
    every = asked["unknown"] or scene.unknown
    _check_unknown(every)
    if estimate is not None:
        check_same_body(estimate, scene)
    doubt = _doubt(settings, every)
    scales = tuple(name for name in every if name in SCALES)
    asked["unknown"] = tuple(name for name in every if name not in SCALES)
    prior = _prior(settings, scene, every)
    require_writable(out)
    candidates, split = build_candidates(settings["candidates"], scene), _split(settings, every)
    print("meshing and compiling come first", file=sys.stderr)
    whole = _slopes(scene, asked, (*scales, *doubt), choice)
    others = _others(scene, asked, scales, choice, candidates, unknowns_of(whole, doubt))
    here = Analysis(
        settings, scene, whole, doubt, others, split, prior, model_error, wanted, fitted, begun
    )
    why = _no_refits(fitted, scales, choice, refits.budget)
    none = Refits(left_out=[f"Profiles, basins and scatter: {why or 'they are being made'}."])
    if fitted is None:
        none.left_out.append(
            "What cells and steps make wrong, which may well be more than the noise: no interval "
            "here allows for it; after a fit they do."
        )
    record, left = here.leave(out, none, FieldsLeft()), FieldsLeft()
    if fitted is not None and fitted.varies:
        left = fields_left(scene, fitted, of_fields)
        if left.posterior is not None:
            asked_of = {"draws": of_fields.bands, "seed": of_fields.seed}
            write_fields_left(out / "fields.npz", left.posterior, left.bands, **asked_of)
        record = here.leave(out, none, left)
    if not why:
        record = here.leave(out, refit(scene, asked, prior, model_error, refits), left)
    told = "\n".join([*record["sentences"], *record["left_out"]])
    print(f"{identifiability_table(record)}\n\n{told}\n\n{out / 'identifiability.html'}")


def _wanted(settings: Mapping[str, Any], fitted: Fitted | None) -> tuple[Wanted, WantedOfFields]:
    """What is to be fitted anew, and what is to be told of fields. Raises `InputError`."""
    budget = _budget(settings)
    draws = number(settings, "draws", whole=True, above=-1)
    controls = number(settings, "controls", whole=True, above=-1)
    bands = number(settings, "bands", whole=True, above=-1)
    if bands == 1:
        raise InputError(
            "a band takes several draws", where="bands", value=bands, limit="0, or 2 or more",
            remedy="leave it at 20, or give 0 to make none",
        )  # fmt: skip
    seed = number(settings, "seed", whole=True)
    refits = Wanted(budget, _starts(settings["starts"]), draws, seed)
    regions = build_regions(settings["regions"], fitted)
    return refits, WantedOfFields(budget, controls, bands, seed, regions)


def _budget(settings: Mapping[str, Any]) -> float:
    """Time for what is fitted anew [s]. Raises `InputError`."""
    value = number(settings, "budget")
    if value < 0:
        raise InputError(
            "there is no such time", where="budget", value=value, limit="0 s or more",
            remedy="give 0 to fit nothing anew",
        )  # fmt: skip
    return value


def _check_unknown(every: tuple[str, ...]) -> None:
    """Refuse names that are none, and factors alone. Raises `InputError`."""
    wrong = [name for name in every if name not in QUANTITIES and name not in SCALES]
    if wrong or all(name in SCALES for name in every):
        raise InputError(
            "this is no unknown" if wrong else "factors alone cannot be asked for",
            where="unknown", value=wrong[0] if wrong else ", ".join(every),
            limit=f"{', '.join(QUANTITIES)}, and beside one of these {', '.join(SCALES)}",
            remedy="give unknown=[conductivity,heater_power], for example, and what is known of "
            "the one a narrow spread",
        )  # fmt: skip


def _split(settings: Mapping[str, Any], every: tuple[str, ...]) -> tuple[str, str] | None:
    """Two unknowns to be told apart by a next run. Raises `InputError`."""
    asked = names(settings["split"], "split")
    if asked is None:
        return None
    if len(set(asked)) != 2 or not set(asked) <= set(every):
        raise InputError(
            "these two cannot be told apart", where="split", value=", ".join(asked),
            limit=f"two of {', '.join(every)}", remedy="name two unknowns",
        )  # fmt: skip
    return asked[0], asked[1]


def _others(
    scene: Scene,
    asked: dict[str, Any],
    scales: tuple[str, ...],
    choice: Any,
    candidates: dict[str, Run],
    at: inverse.Sensitivity,
) -> dict[str, inverse.Sensitivity]:
    """Slopes of each run that could be made [K], where those of `at` were taken."""
    if not candidates:
        return {}
    values = {name: value for name, value in zip(at.names, at.values, strict=True)}
    there = {name: value for name, value in values.items() if name in QUANTITIES}
    more = {**asked, "runs": tuple(candidates), "initial": {**asked["initial"], **there}}
    found = _slopes(replace(scene, runs=candidates, scale_deviation=0.0), more, scales, choice)
    return {
        name: replace(
            found,
            slopes={name: found.slopes[name]},
            noise={name: found.noise[name]},
            staying={name: found.staying[name]},
        )
        for name in candidates
    }


def _slopes(
    scene: Scene, asked: dict[str, Any], more: tuple[str, ...], choice: Any
) -> inverse.Sensitivity:
    """Slopes by what is `asked` [K], and by more quantities and factors."""
    unknown = (*asked["unknown"], *(name for name in more if name not in SCALES))
    scales = tuple(name for name in more if name in SCALES)
    return inverse.sensitivity(
        scene,
        runs=asked["runs"],
        unknown=unknown,
        choice=choice,
        stepping=asked["stepping"],
        meshing=asked["meshing"],
        initial=asked["initial"],
        scales=scales,
    )


def _starts(value: Any) -> tuple[float, ...]:
    """Factors on the values found [1]. Raises `InputError`."""
    if not isinstance(value, list):
        raise InputError(
            "a list of factors is wanted", where="starts", value=value, limit="[0.3,3]",
            remedy="write starts=[0.3,3], in quotes if the shell minds brackets, or starts=[]",
        )  # fmt: skip
    return tuple(number({"starts": factor}, "starts", above=0.0) for factor in value)


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


def _doubt(settings: Mapping[str, Any], unknown: tuple[str, ...]) -> dict[str, float]:
    """By how much logarithms of stated values may be off [1]."""
    doubt = given(settings["doubt"], "doubt.")
    for name, value in doubt.items():
        if name in unknown or value <= 0:
            raise InputError(
                "this doubt cannot be", where=f"doubt.{name}", value=value,
                limit=f"a number above 0, of what is no unknown ({', '.join(unknown)})",
                remedy="give by how much the logarithm of a stated value may be off, 0.02 for 2 %",
            )  # fmt: skip
    return doubt


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


def _no_refits(fitted: Fitted | None, scales: tuple[str, ...], choice: Any, budget: float) -> str:
    """Why nothing is fitted anew, nothing where it is."""
    if fitted is None:
        return "it takes a fit, give estimate=DIR"
    if budget <= 0:
        return "budget is 0"
    if scales:
        return f"{', '.join(scales)} cannot be fitted yet"
    if not isinstance(choice, Uniform):
        return "only values of the whole body have them"
    if fitted.uneven:
        return "the fit found fields that vary, of which one value each says nothing"
    return ""
