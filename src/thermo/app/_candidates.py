"""Runs that could be made next, from those of the scene and what would be other about them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.spatial import KDTree

from thermo.app._configuration import number
from thermo.errors import InputError
from thermo.mesh import read_surface
from thermo.observe import Heater, Recording, Run, Scene, seen_from

_LAMP = ("centre", "direction", "radius", "power", "until", "rise")
_AROUND = ("initial_temperature", "ambient_temperature", "radiation_temperature")


def build_candidates(section: Any, scene: Scene) -> dict[str, Run]:
    """By name, each run that could be made [SI]; nothing without a section.

    An entry is `like`, the run of the scene whose samples, frames and conditions it has, and what
    is other: temperatures, parts of the lamp, `duration` [s], over which its frames are spread, or
    the place of a `camera` [m], which sees as many samples as `like` has, others. Temperatures of
    its recording are those of `like` and mean nothing.

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
    known = ("like", "duration", "camera", *_AROUND, *_LAMP)
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
    if "camera" in entry:
        record = _seen(record, entry["camera"], scene, f"{where}.camera")
    lamp = {key: entry[key] for key in _LAMP if key in entry}
    heater = like.heater if not lamp else _lamp(like, lamp, where)
    return replace(like, name=name, recording=record, heater=heater, **around, where=where)


def _seen(record: Recording, camera: Any, scene: Scene, where: str) -> Recording:
    """As many samples where a camera sees them; each reads as the nearest one of the record."""
    surface = read_surface(scene.surface_path, unit=scene.unit)  # type: ignore[arg-type]
    points = seen_from(surface, _place(camera, where), len(record.points), where=where)
    _, near = KDTree(record.points).query(points)
    quiet = None if record.quiet is None else record.quiet[:, near]
    return Recording(points, record.time, record.temperature[:, near], record.valid[:, near], quiet)


def _place(value: Any, where: str) -> Float[np.ndarray, "3"]:
    """A point [m]. Raises `InputError`."""
    try:
        place = np.asarray(value, dtype=float)
        if place.shape != (3,) or not np.isfinite(place).all():
            raise ValueError
    except (TypeError, ValueError) as fault:
        raise InputError(
            "a place is three numbers", where=where, value=value, limit="[x,y,z] in metres",
            remedy="give it in the axes of the surface, [0,0,0.3] for example",
        ) from fault  # fmt: skip
    return place


def _lamp(like: Run, lamp: Mapping[str, Any], where: str) -> Heater:
    if like.heater is None:
        raise InputError(
            "there is no lamp to be otherwise", where=where, value=", ".join(lamp),
            limit="a run with a heater as `like`", remedy=f"take another run than {like.name}",
        )  # fmt: skip
    parts = {key: getattr(like.heater, key) for key in (*_LAMP, "course")}
    given = {
        key: value if isinstance(value, list) else number(lamp, key, f"{where}.")
        for key, value in lamp.items()
    }
    return Heater(**{**parts, **given}, where=where)
