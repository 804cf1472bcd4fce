"""Reads a scene folder."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from thermo.errors import InputError

from ._air import Air
from ._box import Box
from ._course import Course
from ._heater import Heater
from ._number import real_array, shown
from ._prescribed import Prescribed, read_history
from ._recording_read import read_recording
from ._scene import QUANTITIES, Run, Scene, StatedMaterial, check_run_name
from ._section import Section, read_json
from ._temperature_table import TemperatureTable

FORMAT: Final = "thermofield-scene/1"
"""The format of a scene folder that this version reads and writes."""

PRIOR_ENDING: Final = "_relative_sd"

_REQUIRED = ("format", "surface", "material", "surface_exchange", "runs")
_OPTIONAL = (
    "object", "unit", "scale_deviation", "unknown", "prior", "truth", "description", "notes",
)  # fmt: skip
_RUN_REQUIRED = (
    "recording", "initial_temperature", "ambient_temperature", "radiation_temperature",
)  # fmt: skip
_RUN_OPTIONAL = (
    "heater", "held_out", "prescribed", "insulated", "air", "constant_error", "description",
    "notes",
)  # fmt: skip
_HEATER = ("centre", "direction", "radius", "power", "until")


def read_scene(folder: Path | str) -> Scene:
    """Read a scene folder with all its recordings.

    `scene.json` has these keys (all SI, temperatures in kelvin; * is optional):

    - `format`: `thermofield-scene/1`. `object`*: its name. `description`*, `notes`*: ignored.
    - `surface`: file of the closed triangle surface. `unit`*: m (default), cm, mm or inch, the
        unit of that file alone.
    - `scale_deviation`*: standard deviation of the surface's scale over the scale (1).
    - `material`: `name`*, `density` [kg/m3], `heat_capacity` [J/kg/K], `conductivity` [W/m/K];
        the last may be null where it is to be found. Either of the last two may be an object with
        `temperature` [K] and `value`, see `TemperatureTable`.
    - `surface_exchange`: `convection` [W/m2/K], `emissivity` (1); null where to be found.
    - `unknown`*: what a fit recovers by default, names from `QUANTITIES`.
    - `prior`*: `QUANTITY_relative_sd`, relative standard deviation of a stated value.
    - `runs.NAME`: `recording` (file), `initial_temperature`, `ambient_temperature`,
        `radiation_temperature` [K], `heater`*, `held_out`*, `prescribed`*, `insulated`*,
        `air`*, `constant_error`* [K].
    - `runs.NAME.heater`: null, or `centre`, `direction`, `radius`, `power`, `until`, `rise`*,
        `kind`* (only `spot`), `course`* with `time` [s] and `share` (1); see `Heater`.
    - `runs.NAME.insulated`: a list of boxes [[x, y, z], [x, y, z]] [m]; see `Run`.
    - `runs.NAME.air`: a list of entries with `box` [m], `convection` [W/m2/K] and `temperature`
        [K]; see `Air`.
    - `runs.NAME.prescribed`: a list of histories, each with `box` [[x, y, z], [x, y, z]] [m],
        and either `history` (a file, see `read_history`) or `time` [s] and `temperature` [K].
    - `truth`*: for scoring by others; it is dropped unread.

    Paths are relative to the folder. The surface file must exist but is not read here.

    Arguments:

    - `folder`: the folder, or its `scene.json`.

    Raises `InputError`, which names the file and key, for anything else than the above.
    """
    file = Path(folder)
    file = file if file.name == "scene.json" else file / "scene.json"
    root = read_json(file)
    root.table.pop("truth", None)  # an estimate must not depend on it
    _check_format(root)
    root.check_keys(_REQUIRED, _OPTIONAL)
    exchange = root.section("surface_exchange")
    exchange.check_keys(("convection", "emissivity"))
    return Scene(
        folder=file.parent,
        object=root.text("object", file.absolute().parent.name),
        surface_path=file.parent / root.text("surface"),
        unit=root.text("unit", "m"),
        material=_material(root.section("material")),
        convection=exchange.number_or_null("convection"),
        emissivity=exchange.number_or_null("emissivity"),
        unknown=_unknown(root),
        prior=_prior(root.section("prior")),
        runs=_runs(root.section("runs")),
        scale_deviation=root.number_or_null("scale_deviation") or 0.0,
        where=str(file),
    )


def _check_format(root: Section) -> None:
    found = root.table.get("format")
    if found != FORMAT:
        raise InputError(
            "unknown format of the scene", where=root.where("format"), value=shown(found),
            limit=FORMAT, remedy=f'write "format": "{FORMAT}", or update this program',
        )  # fmt: skip


def _material(section: Section) -> StatedMaterial:
    section.check_keys(("density", "heat_capacity", "conductivity"), ("name",))
    return StatedMaterial(
        name=section.text("name", "unnamed"),
        density=section.number("density"),
        heat_capacity=_property(section, "heat_capacity") or section.number("heat_capacity"),
        conductivity=_property(section, "conductivity") or section.number_or_null("conductivity"),
        where=section.where(),
    )


def _property(material: Section, key: str) -> TemperatureTable | None:
    stated = material.table.get(key)
    if isinstance(stated, str | list):
        raise material.wrong(key, 'a number, or as {"temperature": [...], "value": [...]}')
    if not isinstance(stated, dict):
        return None
    section = material.section(key)
    section.check_keys(("temperature", "value"))
    columns = (tuple(section.array(name).tolist()) for name in ("temperature", "value"))
    return TemperatureTable(*columns, where=section.where())


def _unknown(root: Section) -> tuple[str, ...]:
    names = root.items("unknown")
    if not all(isinstance(name, str) for name in names):
        raise root.wrong("unknown", f"a list of names from {', '.join(QUANTITIES)}")
    return tuple(names)


def _prior(section: Section) -> dict[str, float]:
    section.check_keys((), tuple(name + PRIOR_ENDING for name in QUANTITIES))
    return {key.removesuffix(PRIOR_ENDING): section.number(key) for key in section.table}


def _runs(section: Section) -> dict[str, Run]:
    # The keys of all runs are checked before the first recording is read.
    for name in section.table:
        check_run_name(name, section.where(name))
        section.section(name).check_keys(_RUN_REQUIRED, _RUN_OPTIONAL)
    return {name: _run(section.section(name), name) for name in section.table}


def _run(section: Section, name: str) -> Run:
    histories = range(len(section.items("prescribed")))
    return Run(
        name=name,
        initial_temperature=section.number("initial_temperature"),
        ambient_temperature=section.number("ambient_temperature"),
        radiation_temperature=section.number("radiation_temperature"),
        heater=_heater(section),
        held_out=section.flag("held_out", False),
        prescribed=tuple(_prescribed(section, number) for number in histories),
        insulated=tuple(_insulated(section)),
        air=tuple(_air(section, number) for number in range(len(section.items("air")))),
        constant_error=section.number_or_null("constant_error") or 0.0,
        recording=read_recording(section.file.parent / section.text("recording")),
        where=section.where(),
    )


def _heater(run: Section) -> Heater | None:
    if run.table.get("heater") is None:
        return None
    section = run.section("heater")
    section.check_keys(_HEATER, ("rise", "kind", "course"))
    if section.text("kind", "spot") != "spot":
        raise section.wrong("kind", '"spot", the one kind of lamp')
    return Heater(
        centre=section.array("centre"),
        direction=section.array("direction"),
        radius=section.number("radius"),
        power=section.number("power"),
        until=section.number("until"),
        rise=section.number_or_null("rise") or 0.0,
        course=_course(section),
        where=section.where(),
    )


def _course(heater: Section) -> Course | None:
    if heater.table.get("course") is None:
        return None
    section = heater.section("course")
    section.check_keys(("time", "share"))
    return Course(section.array("time"), section.array("share"), where=section.where())


def _insulated(run: Section) -> list[Box]:
    found = []
    for number, corners in enumerate(run.items("insulated")):
        key = f"insulated[{number}]"
        section = Section(run.file, run.path, {key: corners})
        found.append(_box(section, key))
    return found


def _air(run: Section, number: int) -> Air:
    key = f"air[{number}]"
    section = Section(run.file, run.path, {key: run.table["air"][number]}).section(key)
    section.check_keys(("box", "convection", "temperature"))
    return Air(
        _box(section, "box"), section.number("convection"), section.number("temperature"),
        where=section.where(),
    )  # fmt: skip


def _box(section: Section, key: str) -> Box:
    corners = section.items(key)
    if len(corners) != 2:
        raise section.wrong(key, "two corners [[x, y, z], [x, y, z]] [m]")
    where = section.where(key)
    low, high = (
        real_array(corner, where=where, quantity="corner of the box [m]") for corner in corners
    )
    return Box(low, high, where=where)


def _prescribed(run: Section, number: int) -> Prescribed:
    key = f"prescribed[{number}]"
    entry = run.table["prescribed"][number]
    section = Section(run.file, run.path, {key: entry}).section(key)
    from_file = "history" in section.table
    section.check_keys(("box", "history") if from_file else ("box", "time", "temperature"))
    box = _box(section, "box")
    if from_file:
        time, temperature = read_history(run.file.parent / section.text("history"))
    else:
        time, temperature = section.array("time"), section.array("temperature")
    return Prescribed(box.low, box.high, time, temperature, where=section.where())
