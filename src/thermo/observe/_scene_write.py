"""Writes a scene folder."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

from thermo.errors import InputError

from ._atomic import unwritable
from ._box import Box
from ._heater import Heater
from ._npz import check_file, write_npz
from ._recording_write import write_recording
from ._scene import Run, Scene, check_run_name
from ._scene_read import FORMAT, PRIOR_ENDING, read_scene
from ._temperature_table import TemperatureTable


def write_scene(folder: Path | str, scene: Scene) -> None:
    """Write a scene folder: `scene.json`, the surface file, and one NPZ a run.

    All files are written to a temporary folder beside it and read back. Only then are they moved,
    `scene.json` last, so that no half-written scene can be read. Other files that stand in the
    folder stay. `read_scene` gives every number back bit for bit.

    Arguments:

    - `folder`: made where it does not exist.
    - `scene`: what to write; its surface file is copied as `surface` with its own ending.

    Raises `InputError` if the folder cannot be written, or if the scene is one that `read_scene`
    would refuse.
    """
    target = Path(folder)
    check_file(scene.surface_path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=target.parent, prefix=f".{target.name}.") as name:
            stage = Path(name)
            _stage(stage, target, scene)
            target.mkdir(exist_ok=True)
            for file in sorted(stage.iterdir(), key=lambda path: path.name == "scene.json"):
                os.replace(file, target / file.name)
    except OSError as error:
        raise unwritable(target, error) from error


def _stage(stage: Path, target: Path, scene: Scene) -> None:
    try:
        _write_files(stage, scene)
        read_scene(stage)
    except InputError as error:
        raise InputError(
            error.what, where=error.where.replace(str(stage), str(target)), value=error.value,
            limit=error.limit, remedy=error.remedy,
        ) from error  # fmt: skip


def _write_files(stage: Path, scene: Scene) -> None:
    surface = "surface" + scene.surface_path.suffix
    shutil.copyfile(scene.surface_path, stage / surface)
    table: dict[str, Any] = {
        "format": FORMAT,
        "object": scene.object,
        "surface": surface,
        "unit": scene.unit,
        "material": {
            "name": scene.material.name,
            "density": scene.material.density,
            "heat_capacity": _property(scene.material.heat_capacity),
            "conductivity": _property(scene.material.conductivity),
        },
        "surface_exchange": {"convection": scene.convection, "emissivity": scene.emissivity},
        "unknown": list(scene.unknown),
        "prior": {name + PRIOR_ENDING: value for name, value in scene.prior.items()},
        "runs": {name: _write_run(stage, name, run) for name, run in scene.runs.items()},
    }
    if scene.scale_deviation:
        table["scale_deviation"] = scene.scale_deviation
    text = json.dumps(table, indent=1, default=float) + "\n"
    (stage / "scene.json").write_text(text, encoding="utf-8")


def _property(stated: float | TemperatureTable | None) -> float | dict[str, list[float]] | None:
    if isinstance(stated, TemperatureTable):
        return {"temperature": list(stated.temperature), "value": list(stated.value)}
    return stated


def _write_run(stage: Path, name: str, run: Run) -> dict[str, Any]:
    check_run_name(name, f"run {name!r}")
    recording = f"{name}.npz"
    write_recording(stage / recording, run.recording)
    table: dict[str, Any] = {
        "recording": recording,
        "initial_temperature": run.initial_temperature,
        "ambient_temperature": run.ambient_temperature,
        "radiation_temperature": run.radiation_temperature,
        "heater": None if run.heater is None else _heater(run.heater),
        "held_out": bool(run.held_out),
    }
    histories = []
    for number, history in enumerate(run.prescribed):
        # "+" cannot stand in a run's name, so no two files can meet.
        file = f"{name}+prescribed_{number}.npz"
        write_npz(stage / file, {"time": history.time, "temperature": history.temperature})
        histories.append({"box": _corners(history.box()), "history": file})
    if histories:
        table["prescribed"] = histories
    if run.insulated:
        table["insulated"] = [_corners(box) for box in run.insulated]
    if run.air:
        table["air"] = [
            {
                "box": _corners(one.box),
                "convection": one.convection,
                "temperature": one.temperature,
            }
            for one in run.air
        ]
    if run.constant_error:
        table["constant_error"] = run.constant_error
    return table


def _corners(box: Box) -> list[list[float]]:
    return [box.low.tolist(), box.high.tolist()]


def _heater(heater: Heater) -> dict[str, Any]:
    table: dict[str, Any] = {
        "kind": "spot",
        "centre": heater.centre.tolist(),
        "direction": heater.direction.tolist(),
        "radius": heater.radius,
        "power": heater.power,
        "until": heater.until,
        "rise": heater.rise,
    }
    if heater.course is not None:
        course = {"time": heater.course.time.tolist(), "share": heater.course.share.tolist()}
        table["course"] = course
    return table
