"""A scene from the settings of a command."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from thermo.app._configuration import flag, names, number
from thermo.errors import InputError
from thermo.mesh import Surface, read_surface
from thermo.observe import Heater, Recording, Run, Scene, StatedMaterial, read_scene, real_array

# K, what data sheets of calibrated microbolometers state (2 K or 2 %): within it nothing need be
# wrong.
_ACCURACY = 2.0
# K, ten times that, which no calibration is off by; Celsius for kelvin is, and 7 % of a scale.
_ANOTHER_SCALE = 20.0
_UNTIL_READ = 300.0  # K, in place of an initial temperature that the frames are to tell
_LAMP = ("centre", "direction", "radius", "power", "until", "rise")


def stated_scene(settings: Mapping[str, Any]) -> tuple[Scene, Surface]:
    """The scene that will be left, with a blank recording in its run, and its surface [m].

    Raises `InputError` for what is missing and for conditions that make no scene, before any frames
    are read.
    """
    if (settings["surface"] is None) == (settings["scene"] is None):
        raise InputError(
            "one of `surface` and `scene` is wanted", where="surface",
            value=f"surface {settings['surface']}, scene {settings['scene']}",
            limit="a closed surface, or a scene that has one",
            remedy="give surface=FILE for a new scene, scene=FOLDER to add a run to one",
        )  # fmt: skip
    known = dict(settings)
    if known["initial_temperature"] is None:
        known["initial_temperature"] = _UNTIL_READ
    blank = Recording(np.zeros((1, 3)), np.array([0.0, 1.0]), np.full((2, 1), _UNTIL_READ))
    if settings["scene"] is not None:
        standing = read_scene(Path(settings["scene"]))
        surface = read_surface(standing.surface_path, unit=standing.unit)
        return _with_run(standing, run_of(known, blank)), surface
    path, unit, deviation = _surface_of(settings)
    surface = read_surface(path, unit=unit)
    made = _new_scene(settings, path, unit, run_of(known, blank))
    return replace(made, scale_deviation=deviation), surface


def check_room(settings: Mapping[str, Any]) -> None:
    """Refuse to lay a scene over one that has other runs. Raises `InputError`."""
    out = Path(settings["out"])
    if not (out / "scene.json").is_file() or settings["scene"] is not None:
        return
    others = [name for name in read_scene(out).runs if name != str(settings["run"])]
    if others:
        raise InputError(
            "there is a scene with other runs", where=str(out / "scene.json"),
            value=", ".join(others), limit="a folder without a scene, or with this run alone",
            remedy=f"give scene={out} in place of surface to add the run, or another out",
        )  # fmt: skip


def compare_start(run: Run) -> list[str]:
    """In words, where what is read first is off from the stated start by more than cameras are [K].

    Raises `InputError` where it is so far off that it must be of another scale.
    """
    record = run.recording
    first = record.temperature[0][record.valid[0]]
    if record.quiet is not None:
        first = record.quiet[np.isfinite(record.quiet)]
    # A lamp may have heated part of the object by the first frame: the median stays.
    off = float(np.median(first)) - run.initial_temperature if first.size else 0.0
    if abs(off) > _ANOTHER_SCALE:
        raise InputError(
            "the frames do not begin at the stated temperature", where="initial_temperature",
            value=f"{run.initial_temperature:g} K; the first readings are {off:+.4g} K off",
            limit=f"within {_ANOTHER_SCALE:g} K",
            remedy="check the unit and scale of the frames (recording.unit, .scale, .offset), the "
            "emissivity, and when the run begins",
        )  # fmt: skip
    if abs(off) <= _ACCURACY:
        return []
    return [
        f"the first readings are {off:+.2g} K off the stated initial temperature, more than the "
        f"{_ACCURACY:g} K to which thermal cameras are calibrated"
    ]


def run_of(settings: Mapping[str, Any], recording: Recording) -> Run:
    """The run of a recording under the stated conditions [SI]. Raises `InputError`."""
    ambient = settings["ambient_temperature"]
    around = settings["radiation_temperature"]
    return Run(
        name=str(settings["run"]),
        recording=recording,
        initial_temperature=_initial(settings["initial_temperature"], recording),
        ambient_temperature=ambient,
        radiation_temperature=ambient if around is None else around,
        heater=_heater(settings["heater"]),
        held_out=flag(settings, "held_out"),
        where=f"run {settings['run']}",
    )


def _surface_of(settings: Mapping[str, Any]) -> tuple[Path, str, Any]:
    """Its file, the unit of that, and the relative deviation of its scale [1].

    `surface` may be what `thermo reconstruct` left, whose record tells the last.
    """
    path, unit = Path(settings["surface"]), str(settings["unit"])
    stated = settings["scale_deviation"]
    if not path.is_dir():
        return path, unit, 0.0 if stated is None else stated
    try:
        record = json.loads((path / "result.json").read_text("utf-8"))
        scale, file = record["scale"], path / record["surface"]["file"]
        told = 0.0 if scale is None else scale["relative_deviation"]
    except (OSError, ValueError, KeyError, TypeError) as fault:
        raise InputError(
            "this folder holds no surface", where="surface", value=str(path),
            limit="a file, or a folder that `thermo reconstruct` left", remedy="name the file",
        ) from fault  # fmt: skip
    return file, "m", told if stated is None else stated


def _with_run(scene: Scene, run: Run) -> Scene:
    if run.name in scene.runs:
        raise InputError(
            "there is a run of this name", where="run", value=run.name,
            limit=f"another than {', '.join(scene.runs)}", remedy="give run=NAME",
        )  # fmt: skip
    return replace(scene, runs=scene.runs | {run.name: run})


def _new_scene(settings: Mapping[str, Any], surface: Path, unit: str, run: Run) -> Scene:
    stated, exchange = settings["material"], settings["surface_exchange"]
    return Scene(
        folder=Path(settings["out"]),
        object=str(settings["object"]),
        surface_path=surface,
        unit=unit,
        material=StatedMaterial(
            str(stated["name"]),
            number(stated, "density", "material."),
            number(stated, "heat_capacity", "material."),
            stated["conductivity"],
        ),
        convection=exchange["convection"],
        emissivity=exchange["emissivity"],
        unknown=names(settings["unknown"], "unknown") or (),
        prior={},
        runs={run.name: run},
        where="settings",
    )


def _initial(given: float | None, recording: Recording) -> float:
    """What is stated, or the mean of the frames before time 0 [K]."""
    if given is None and recording.quiet is None:
        raise InputError(
            "the temperature at the start is not known", where="initial_temperature",
            value="null, and no frames before time 0", limit="kelvin",
            remedy="give initial_temperature, or record some frames before the run begins",
        )  # fmt: skip
    return float(np.nanmean(np.asarray(recording.quiet))) if given is None else given


def _heater(given: Any) -> Heater | None:
    if given is None:
        return None
    missing = [key for key in _LAMP[:-1] if not isinstance(given, Mapping) or key not in given]
    if missing or set(given) - set(_LAMP):
        raise InputError(
            "this is no lamp", where="heater", value=given, limit=", ".join(_LAMP),
            remedy="give heater='{centre:[x,y,z],direction:[x,y,z],radius:R,power:P,until:T}'",
        )  # fmt: skip
    vectors = {
        key: real_array(given[key], where=f"heater.{key}", quantity=f"{key} of the lamp")
        for key in ("centre", "direction")
    }
    return Heater(**{**given, **vectors}, where="heater")
