"""One case of a study: what was to be expected, the fit, its error, and its predictions."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from thermo.identify import expected_errors
from thermo.inverse import (
    PREDICTION_NODES,
    SCANNED_CONDUCTIVITIES,
    Estimate,
    FieldScores,
    Meshing,
    Prediction,
    field_scores,
    invert,
    predict,
    sensitivity,
    simulate,
)
from thermo.observe import Scene
from thermo.report import write_json
from thermo.study._case import Case, truth
from thermo.study._maps import write_maps
from thermo.study._paper import HELD_OUT

WANTED = 0.05
"""Relative error [1] that a run is asked to stay within before it is called informed."""


def study_case(case: Case, folder: Path) -> dict[str, Any]:
    """Fit a case and say how good it was; what an earlier call left is not done again.

    Arguments:

    - `folder`: where the record of the case goes, its maps, and its checkpoint while it is fitted.

    Returns numbers with SI units and seconds, and writes them as JSON.
    """
    path = folder / f"{case.name()}.json"
    key = case.key()
    if path.exists():
        record = json.loads(path.read_text("utf-8"))
        if record.get("key") == key:
            return record
    found = _guessed(case) if case.preset.optimiser is None else _fitted(case, folder)
    record = {
        "key": key,
        "part": case.part,
        "row": case.row.name(),
        "object": case.row.object,
        "process": case.row.process,
        "quantity": case.row.quantity,
        "preset": case.preset_name,
        "noise": "camera" if case.noisy else "none",
        "seed": case.seed,
        "start": case.start,
        "step": case.step,
        **found,
    }
    write_json(path, record)
    (folder / f"{case.name()}.npz").unlink(missing_ok=True)
    return record


def _fitted(case: Case, folder: Path) -> dict[str, Any]:
    row, preset, scene = case.row, case.preset, case.scene()
    asked: dict[str, Any] = {"runs": row.runs(), "unknown": (row.quantity,)}
    asked |= {"initial": dict(row.known), "seed": case.seed, "meshing": preset.meshing}
    found: dict[str, Any] = {}
    if case.part in ("tables", "processes"):
        begun = time.monotonic()
        (expected,) = expected_errors(sensitivity(scene, **asked))
        found |= {"expected": expected.relative, "informed": expected.informed(WANTED)}
        found |= {"response": expected.response, "verdict_seconds": time.monotonic() - begun}
    prior = preset.prior
    if case.step is not None:
        prior = dataclasses.replace(prior, step=case.step)
    estimate = invert(
        scene, choice=preset.choice, optimiser=preset.optimiser, prior=prior,
        stepping=preset.stepping, checkpoint=folder / f"{case.name()}.npz",
        start=row.start * case.start, **asked,
    )  # fmt: skip
    field, runs = estimate.fields[row.quantity], estimate.runs.values()
    found |= {
        **dataclasses.asdict(field_scores(estimate.mesh, field, truth(scene, row.quantity))),
        "rmse": float(np.sqrt(np.mean([run.rmse**2 for run in runs]))),
        "final_mae": float(np.mean([run.final_mae() for run in runs])),
        "deviation": {name: run.deviation for name, run in estimate.runs.items()},
        "smoothness": estimate.smoothness,
        "success": estimate.success,
        "iterations": [len(losses) for losses in estimate.history],
        "seconds": estimate.seconds,
    }
    if case.held_out:
        made = _predictions(scene, estimate, case)
        found["held_out"] = _scores(made)
        true = truth(scene, row.quantity)
        write_maps(folder / f"{case.name()}-maps.npz", scene, estimate, field, true, made)
    return found


def _held_out(case: Case, scene: Scene) -> tuple[dict[str, str], Meshing]:
    """Names of the runs to predict by what they test, and the mesh to do it on."""
    meshing = Meshing(max_nodes=PREDICTION_NODES, cache=case.preset.meshing.cache)
    return {name: run for name, run in HELD_OUT.items() if run in scene.runs}, meshing


def _predictions(scene: Scene, estimate: Estimate, case: Case) -> dict[str, Prediction]:
    there, meshing = _held_out(case, scene)
    made = predict(scene, estimate, runs=tuple(there.values()), meshing=meshing)
    return {name: made[run] for name, run in there.items()}


def _scores(made: Mapping[str, Prediction]) -> dict[str, Any]:
    """Errors [K] of the field and of its median under conditions that were not fitted."""
    return {
        name: {kind: dataclasses.asdict(score) for kind, score in prediction.scores.items()}
        for name, prediction in made.items()
    }


def _guessed(case: Case) -> dict[str, Any]:
    """What is said without any recording: the value that the prior expects, and what follows.

    The prior of a conductivity is even in its logarithm from foam to silver; that of an exchange
    with the air is around the value that the row begins with.
    """
    begun = time.monotonic()
    row, scene = case.row, case.scene()
    if row.quantity == "diffusivity":
        guess = float(np.exp(np.mean(np.log(SCANNED_CONDUCTIVITIES))))
        guess /= scene.material.volumetric_heat_capacity()
    else:
        guess = row.start * truth(scene, row.quantity)
    values = {**row.known, row.quantity: guess}
    there, meshing = _held_out(case, scene)

    def simulated(run: str) -> dict[str, float]:
        made = simulate(scene, run, values=values, meshing=meshing)
        return dataclasses.asdict(made.scores["stated"])

    ratio = guess / truth(scene, row.quantity)
    scores = FieldScores(abs(ratio - 1), abs(ratio - 1), ratio, 0.0, 0.0)
    squares = [simulated(run)["rmse"] ** 2 for run in row.runs()]
    found: dict[str, Any] = {"rmse": float(np.sqrt(np.mean(squares)))}
    if case.held_out:
        both = {name: simulated(run) for name, run in there.items()}
        found |= {"held_out": {n: {"spatial": one, "median": one} for n, one in both.items()}}
    return {**dataclasses.asdict(scores), **found, "seconds": time.monotonic() - begun}
