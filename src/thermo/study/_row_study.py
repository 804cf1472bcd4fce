"""One row of a study: what was to be expected, the fit, its error, and its predictions."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, final

from thermo.errors import InputError
from thermo.identify import expected_errors
from thermo.inverse import Estimate, Meshing, field_scores, invert, predict, sensitivity
from thermo.observe import Scene, read_scene, with_camera_noise
from thermo.report import write_json
from thermo.study._paper import Row
from thermo.study._preset import Preset

WANTED = 0.05
"""Relative error [1] that a run is asked to stay within before it is called informed."""

PREDICTION_NODES = 40000
"""About the most nodes [1] of a mesh that predicts, for every preset."""

HELD_OUT = {"warming": "test_warming", "heating": "test_heating"}


@final
@dataclass(frozen=True)
class Case:
    """A row of a table under one preset.

    - `data`: folder that holds the scenes; `noisy`: whether a camera's noise is put on.
    - `held_out`: whether held-out runs are predicted; `seed`: of noise and fields.
    """

    row: Row
    preset_name: str
    preset: Preset
    data: Path
    noisy: bool
    held_out: bool
    seed: int = 0

    def name(self) -> str:
        """File name of the case without its ending."""
        return f"{self.row.name()}-{self.preset_name}-{'camera' if self.noisy else 'none'}"

    def key(self) -> str:
        """A hash that another case does not share; the meshes' folder is no part of it."""
        meshing = replace(self.preset.meshing, cache=None)
        asked = replace(self, data=Path(), preset=replace(self.preset, meshing=meshing))
        scene = (self.data / self.row.object / "scene.json").read_bytes()
        return hashlib.sha256(repr(asked).encode() + scene).hexdigest()[:16]


def truth(scene: Scene, quantity: str) -> float:
    """The true value [SI] of a scene of the paper. Fits never see it.

    Raises `InputError` where the scene does not tell.
    """
    capacity = scene.material.density * scene.material.heat_capacity
    if quantity == "scaled_convection" and scene.convection is not None:
        return scene.convection / capacity
    told = json.loads((scene.folder / "scene.json").read_text("utf-8")).get("truth", {})
    if quantity not in told:
        raise InputError(
            "the scene does not tell the truth that a study compares with",
            where=f"{scene.folder}/scene.json: truth.{quantity}",
            value="missing",
            limit="a number [SI]",
            remedy="study scenes of which the answer is known",
        )
    return float(told[quantity])


def _seen(case: Case, scene: Scene) -> Scene:
    """The scene as it was recorded: with a camera's noise on what is fitted, if it is asked for."""
    if not case.noisy:
        return scene
    runs = {
        name: run if run.held_out else replace(
            run, recording=with_camera_noise(run.recording, run.initial_temperature, seed=case.seed)
        )
        for name, run in scene.runs.items()
    }  # fmt: skip
    return replace(scene, runs=runs)


def study_row(case: Case, folder: Path) -> dict[str, Any]:
    """Fit a row and say how good it was; what an earlier call left is not done again.

    Arguments:

    - `folder`: where the record of the case goes, and its checkpoint while it is fitted.

    Returns numbers with SI units and seconds, and writes them as JSON.
    """
    path = folder / f"{case.name()}.json"
    key = case.key()
    if path.exists():
        record = json.loads(path.read_text("utf-8"))
        if record.get("key") == key:
            return record
    row, preset = case.row, case.preset
    scene = _seen(case, read_scene(case.data / row.object))
    asked: dict[str, Any] = {"runs": (row.process,), "unknown": (row.quantity,)}
    asked |= {"initial": dict(row.known), "seed": case.seed}
    begun = time.monotonic()
    (expected,) = expected_errors(sensitivity(scene, meshing=preset.meshing, **asked))
    verdict_seconds = time.monotonic() - begun
    estimate = invert(
        scene, choice=preset.choice, optimiser=preset.optimiser, prior=preset.prior,
        stepping=preset.stepping, meshing=preset.meshing,
        checkpoint=folder / f"{case.name()}.npz", start=row.start, **asked,
    )  # fmt: skip
    scores = field_scores(estimate.mesh, estimate.fields[row.quantity], truth(scene, row.quantity))
    record = {
        "key": key,
        "row": row.name(),
        "quantity": row.quantity,
        "preset": case.preset_name,
        "noise": "camera" if case.noisy else "none",
        "expected": expected.relative,
        "informed": expected.informed(WANTED),
        "response": expected.response,
        "verdict_seconds": verdict_seconds,
        **dataclasses.asdict(scores),
        "rmse": estimate.runs[row.process].rmse,
        "deviation": estimate.runs[row.process].deviation,
        "smoothness": estimate.smoothness,
        "success": estimate.success,
        "iterations": [len(losses) for losses in estimate.history],
        "seconds": estimate.seconds,
    }
    if case.held_out:
        record["held_out"] = _predictions(scene, estimate, preset)
    write_json(path, record)
    (folder / f"{case.name()}.npz").unlink(missing_ok=True)
    return record


def _predictions(scene: Scene, estimate: Estimate, preset: Preset) -> dict[str, Any]:
    """Errors [K] of the field and of its median under conditions that were not fitted."""
    meshing = Meshing(max_nodes=PREDICTION_NODES, cache=preset.meshing.cache)
    there = {name: run for name, run in HELD_OUT.items() if run in scene.runs}
    made = predict(scene, estimate, runs=tuple(there.values()), meshing=meshing)
    return {
        name: {kind: dataclasses.asdict(score) for kind, score in made[run].scores.items()}
        for name, run in there.items()
    }
