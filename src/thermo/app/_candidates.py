"""Runs that could be made next, from those of the scene and what would be other about them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from thermo.app._configuration import number
from thermo.errors import InputError
from thermo.observe import Heater, Recording, Run, Scene

_LAMP = ("centre", "direction", "radius", "power", "until", "rise")
_AROUND = ("initial_temperature", "ambient_temperature", "radiation_temperature")


def build_candidates(section: Any, scene: Scene) -> dict[str, Run]:
    """By name, each run that could be made [SI]; nothing without a section.

    An entry is `like`, the run of the scene whose samples, frames and conditions it has, and what
    is other: temperatures, parts of the lamp, or `duration` [s], over which its frames are spread.
    Temperatures of its recording are those of `like` and mean nothing.

    Raises `InputError` for a run that is not there, an unknown key and values that cannot be.
    """
    if section is None:
        return {}
    if not isinstance(section, Mapping):
        raise InputError(
            "runs by name are wanted", where="candidates", value=section,
            limit="{hot: {like: cooling, initial_temperature: 340}}",
            remedy="write 'candidates={hot:{like:cooling,initial_temperature:340}}'",
        )  # fmt: skip
    return {str(name): _candidate(str(name), entry, scene) for name, entry in section.items()}


def _candidate(name: str, entry: Any, scene: Scene) -> Run:
    where = f"candidates.{name}"
    known = ("like", "duration", *_AROUND, *_LAMP)
    if not isinstance(entry, Mapping) or not set(entry) <= set(known):
        odd = entry if not isinstance(entry, Mapping) else min(set(entry) - set(known))
        raise InputError(
            "this is nothing that a run could have otherwise", where=where, value=odd,
            limit=", ".join(known), remedy="give `like`, and what is other about the run",
        )  # fmt: skip
    if entry.get("like") not in scene.runs:
        raise InputError(
            "a candidate is like a run of the scene", where=f"{where}.like",
            value=entry.get("like"), limit=", ".join(scene.runs), remedy="name one of these",
        )  # fmt: skip
    like = scene.runs[entry["like"]]
    around = {key: number(entry, key, f"{where}.") for key in _AROUND if key in entry}
    record = like.recording
    if "duration" in entry:
        longer = number(entry, "duration", f"{where}.", above=0.0) / float(record.time[-1])
        record = Recording(
            record.points, record.time * longer, record.temperature, record.valid, record.quiet
        )
    lamp = {key: entry[key] for key in _LAMP if key in entry}
    heater = like.heater if not lamp else _lamp(like, lamp, where)
    return replace(like, name=name, recording=record, heater=heater, **around, where=where)


def _lamp(like: Run, lamp: Mapping[str, Any], where: str) -> Heater:
    if like.heater is None:
        raise InputError(
            "there is no lamp to be otherwise", where=where, value=", ".join(lamp),
            limit="a run with a heater as `like`", remedy=f"take another run than {like.name}",
        )  # fmt: skip
    parts = {key: getattr(like.heater, key) for key in _LAMP}
    given = {
        key: value if isinstance(value, list) else number(lamp, key, f"{where}.")
        for key, value in lamp.items()
    }
    return Heater(**{**parts, **given}, where=where)
