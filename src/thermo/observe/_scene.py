"""A scene: one object, what is stated about it, and its recordings under several conditions."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import InitVar, dataclass, field
from pathlib import Path
from typing import Final, final

import numpy as np

from thermo.errors import InputError

from ._air import Air
from ._box import Box
from ._heater import Heater
from ._kelvin import check_kelvin_number
from ._noise import Noise, estimate_noise
from ._npz import check_file
from ._number import check_number, shown
from ._prescribed import Prescribed
from ._recording import Recording
from ._temperature_table import TemperatureTable

QUANTITIES: Final = (
    "conductivity",
    "diffusivity",
    "volumetric_heat_capacity",
    "convection",
    "emissivity",
    "scaled_convection",
    "scaled_emissivity",
)
"""Names of the quantities that a fit can recover."""

UNITS: Final = ("m", "cm", "mm", "inch")
"""Units in which a surface file can be."""

_OFF: Final = 20.0
"""A sample that is further off all the time measures nothing [K]."""

_CONSTANT: Final = 5.0
"""A camera reads so much wrong all the time, whatever the run spans [K]."""

_START: Final = 150.0
"""What no camera reads wrong at the start, but a scale whose zero is elsewhere does [K]."""

_CAPACITY: Final = (5e3, 5e7)
"""Of solids, light foam and ten times water among them, for a volume [J/m3/K]."""

_ROUGHEST: Final = 0.5
"""Relative deviation of a scale [1] beyond which its effect is no longer linear at all."""

_BEYOND: Final = 5.0
"""How far readings may lie beyond a table of a property [K]."""

_RUN_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


@final
@dataclass(frozen=True)
class StatedMaterial:
    """What is believed about the material before a fit.

    Arguments:

    - `name`: for people only.
    - `density`: [kg/m3]. `heat_capacity`: [J/kg/K]; a table where it changes with temperature.
    - `conductivity`: [W/m/K], a table likewise; where it is to be found a first guess, of a table
      its level, or None.
    - `where`: what messages call this material.

    Raises `InputError` for a property that is not positive, and for a density and heat capacity
    that no solid has together.
    """

    name: str
    density: float
    heat_capacity: float | TemperatureTable
    conductivity: float | TemperatureTable | None
    where: InitVar[str] = "material"

    def __post_init__(self, where: str) -> None:
        for key, quantity, remedy in (
            ("density", "density [kg/m3]", "give the density in kg/m3 (water: 1000)"),
            ("heat_capacity", "heat capacity [J/kg/K]", "give it in J/kg/K (water: 4180)"),
            ("conductivity", "conductivity [W/m/K]", "give W/m/K, or null if in `unknown`"),
        ):
            value = getattr(self, key)
            if isinstance(value, TemperatureTable) or (key == "conductivity" and value is None):
                continue
            number = check_number(
                value, where=f"{where}.{key}", quantity=quantity, above=0.0, remedy=remedy
            )
            object.__setattr__(self, key, number)  # a whole number becomes a float
        self._check_capacity(where)

    def _check_capacity(self, where: str) -> None:
        least, most = _CAPACITY
        if not least <= self.volumetric_heat_capacity() <= most:
            heat_capacity = _at_reference(self.heat_capacity)
            raise InputError(
                "density times heat capacity is that of no solid", where=where,
                value=f"{self.density:g} kg/m3 * {heat_capacity:g} J/kg/K = "
                f"{self.volumetric_heat_capacity():.3g} J/m3/K",
                limit=f"{least:g} to {most:g} J/m3/K, from light foam to ten times water",
                remedy="give kg/m3 and J/kg/K; g/cm3 and J/g/K are 1000 times as small",
            )  # fmt: skip

    def volumetric_heat_capacity(self) -> float:
        """rho c [J/m3/K]; at `REFERENCE` where it changes with temperature."""
        return self.density * _at_reference(self.heat_capacity)

    def first_conductivity(self) -> float | None:
        """k [W/m/K]; at `REFERENCE` where it changes with temperature."""
        return None if self.conductivity is None else _at_reference(self.conductivity)


def _at_reference(stated: float | TemperatureTable) -> float:
    return stated.at() if isinstance(stated, TemperatureTable) else stated


@final
@dataclass(frozen=True, eq=False)
class Run:
    """One experiment: a recording and the conditions that it was taken under.

    Arguments:

    - `name`: letters, digits and `_ . -`; it names files.
    - `recording`: what was measured.
    - `initial_temperature`: of the whole object at t = 0 [K].
    - `ambient_temperature`: of the air from t = 0 on [K].
    - `radiation_temperature`: of the surroundings that radiate, from t = 0 on [K].
    - `heater`: the lamp, or None.
    - `held_out`: never fitted, only predicted.
    - `constant_error`: standard deviation of what each sample reads wrong all the time [K], where
      the recording has no quiet frames to tell it from.
    - `prescribed`: measured histories that hold on parts of the surface. Each must cover the
        frames of the recording.
    - `insulated`: faces whose centre lies in one of these exchange nothing with air and
        surroundings.
    - `air`: what air there is over parts of the surface, where its convection is known and is not
        that of the rest. Where boxes overlap the later one counts; an insulated face has no air.
    - `noise`: of its readings [K], where that is known otherwise than from the recording; a scene
      that is written does not keep it.
    - `where`: what messages call this run.

    Raises `InputError` for temperatures that cannot be kelvin, an unusable name, a lamp that
    lights after the recording's end, a history that ends before it, or a `constant_error` that is
    negative or has no effect.
    """

    name: str
    recording: Recording
    initial_temperature: float
    ambient_temperature: float
    radiation_temperature: float
    heater: Heater | None = None
    held_out: bool = False
    prescribed: tuple[Prescribed, ...] = ()
    insulated: tuple[Box, ...] = ()
    constant_error: float = 0.0
    air: tuple[Air, ...] = ()
    noise: Noise | None = None
    where: InitVar[str] = "run"

    def __post_init__(self, where: str) -> None:
        check_run_name(self.name, where)
        for key in ("initial_temperature", "ambient_temperature", "radiation_temperature"):
            quantity = key.replace("_", " ")
            number = check_kelvin_number(
                getattr(self, key), where=f"{where}.{key}", quantity=quantity
            )
            object.__setattr__(self, key, number)  # a whole number becomes a float
        object.__setattr__(self, "constant_error", _constant_error(self, where))
        first, last = float(self.recording.time[0]), float(self.recording.time[-1])
        if self.heater is not None and self.heater.first_light() >= last > 0.0:
            raise InputError(
                "the lamp lights after the last frame", where=f"{where}.heater.course.time",
                value=f"{self.heater.first_light():g} s", limit=f"below {last:g} s, the last frame",
                remedy='check the times of frames and course, in seconds from the start; without a '
                'lamp write "heater": null',
            )  # fmt: skip
        for number, history in enumerate(self.prescribed):
            if history.time[0] > first or history.time[-1] < last:
                raise InputError(
                    "history does not cover the recording",
                    where=f"{where}.prescribed[{number}].time",
                    value=f"{history.time[0]:g} to {history.time[-1]:g} s",
                    limit=f"the recording's frames, {first:g} to {last:g} s",
                    remedy="give a longer history, or cut the recording",
                )  # fmt: skip

    def noise_of_readings(self) -> Noise:
        """What is stated, else what the recording tells [K]."""
        return estimate_noise(self.recording) if self.noise is None else self.noise

    def switches(self) -> tuple[float, ...]:
        """Times after the start at which the sources jump [s]."""
        return () if self.heater is None else (float(self.heater.until),)


def _check_start(run: Run, where: str) -> None:
    """Refuse quiet frames, and readings at t = 0, too far from where the run is said to start."""
    recording = run.recording
    read = recording.temperature[recording.valid]
    if not read.size:
        return
    span, quiet = float(np.ptp(read)), recording.quiet
    first = recording.temperature[0][recording.valid[0]]
    if quiet is not None and np.isfinite(quiet).any():
        _check_level(
            run, float(np.nanmean(quiet)), max(_CONSTANT, span / 2), where,
            "the quiet frames show", f"{_CONSTANT:g} K or half of what the run spans",
            "take quiet frames just before t = 0, the body at its start, or leave them out",
        )  # fmt: skip
    if recording.time[0] == 0 and first.size:
        _check_level(
            run, float(np.mean(first)), max(_START, span), where,
            "the readings at t = 0 show", f"{_START:g} K or what the run spans",
            "check the unit of the readings, which may not be what their header says",
        )  # fmt: skip


def _check_level(
    run: Run, level: float, most: float, where: str, shown: str, limit: str, remedy: str
) -> None:
    """Refuse a `level` [K] that is more than `most` [K] from the start."""
    if abs(level - run.initial_temperature) <= most:
        return
    raise InputError(
        f"{shown} the body at another temperature than it starts at",
        where=f"{where}.initial_temperature",
        value=f"{run.initial_temperature:g} K; there the mean is {level:.6g} K",
        limit=f"{most:.3g} K apart, {limit}",
        remedy=f"{remedy}; or correct initial_temperature",
    )


@final
@dataclass(frozen=True, eq=False)
class Scene:
    """One object, what is stated about it, and its runs.

    Arguments:

    - `folder`: where the scene stands.
    - `object`: its name, for people only.
    - `surface_path`: the closed triangle surface. `unit`: the unit of that file.
    - `material`: its stated properties.
    - `convection`: coefficient [W/m2/K], or None where it is to be found.
    - `emissivity`: from 0 to 1, or None where it is to be found.
    - `unknown`: names from `QUANTITIES` that a fit recovers by default.
    - `prior`: relative standard deviation (1) of stated values that are only roughly known.
    - `runs`: by name.
    - `scale_deviation`: standard deviation of the surface's scale over the scale (1), where it was
      rebuilt from photographs, say; 0 where it is exact.
    - `where`: what messages call this scene.

    Raises `InputError` for a missing surface file, values out of range, unknown names, a property
    that is None without being unknown, and quiet frames of a body that is not at its run's start.
    """

    folder: Path
    object: str
    surface_path: Path
    unit: str
    material: StatedMaterial
    convection: float | None
    emissivity: float | None
    unknown: tuple[str, ...]
    prior: dict[str, float]
    runs: dict[str, Run] = field(default_factory=dict)
    scale_deviation: float = 0.0
    where: InitVar[str] = "scene"

    def __post_init__(self, where: str) -> None:
        check_file(self.surface_path)
        if self.unit not in UNITS:
            raise InputError(
                "unknown unit of length", where=f"{where}: unit", value=shown(self.unit),
                limit=", ".join(UNITS), remedy="give the unit of the surface file",
            )  # fmt: skip
        _check_unknown(self.unknown, f"{where}: unknown")
        prior = {name: _deviation(name, value, where) for name, value in self.prior.items()}
        object.__setattr__(self, "prior", prior)
        _check_null(self, where)
        convection, emissivity = _exchange(self.convection, self.emissivity, where)
        object.__setattr__(self, "convection", convection)
        object.__setattr__(self, "emissivity", emissivity)
        scale = check_number(
            self.scale_deviation, where=f"{where}: scale_deviation",
            quantity="relative standard deviation of the scale", least=0.0, most=_ROUGHEST,
            remedy="give it as a fraction, 0.01 for 1 %; 0 or no such key for an exact surface",
        )  # fmt: skip
        object.__setattr__(self, "scale_deviation", scale)
        for key in ("heat_capacity", "conductivity"):
            table = getattr(self.material, key)
            if isinstance(table, TemperatureTable):
                _check_range(table, self.runs, f"{where}: material.{key}.temperature")
        for name, run in self.runs.items():
            _check_start(run, f"{where}: runs.{name}")
        if not self.runs:
            raise InputError(
                "no runs", where=f"{where}: runs", value="an empty table",
                limit="at least one run", remedy="add a run with its recording and temperatures",
            )  # fmt: skip


def _check_range(table: TemperatureTable, runs: Mapping[str, Run], where: str) -> None:
    """Raise `InputError` where readings lie beyond a table: nobody said what holds there."""
    first, last = table.temperature[0] - _BEYOND, table.temperature[-1] + _BEYOND
    for name, run in runs.items():
        read = run.recording.temperature[run.recording.valid]
        if not read.size or (read.min() >= first and read.max() <= last):
            continue
        raise InputError(
            f"readings of run {name} lie beyond a table of the material", where=where,
            value=f"{read.min():.5g} to {read.max():.5g} K",
            limit=f"within the table, {table.temperature[0]:g} to {table.temperature[-1]:g} K",
            remedy="give the property over that range, in kelvin; where it stays as it is, repeat "
            "its last value",
        )  # fmt: skip


def _constant_error(run: Run, where: str) -> float:
    place = f"{where}.constant_error"
    deviation = check_number(
        run.constant_error, where=place, quantity="constant error of a sample [K]", least=0.0,
        most=_OFF, remedy="give its standard deviation in kelvin; a couple's is some tenths",
    )  # fmt: skip
    if deviation > 0.0 and run.recording.knows_quiet():
        raise InputError(
            "a constant error is stated beside quiet frames", where=place, value=f"{deviation:g} K",
            limit="0 where the recording has three quiet frames or more, which tell it",
            remedy="remove `constant_error`, or the recording's `quiet`",
        )  # fmt: skip
    return deviation


def check_run_name(name: str, where: str) -> None:
    """Raise `InputError` unless `name` can name a file."""
    if not _RUN_NAME.fullmatch(name):
        raise InputError(
            "unusable name of a run", where=where, value=shown(name),
            limit="letters, digits and _ . -, beginning with a letter or digit",
            remedy="rename the run; its name becomes a file name",
        )  # fmt: skip


def _check_unknown(unknown: tuple[str, ...], where: str) -> None:
    for position, name in enumerate(unknown):
        _check_quantity(name, where)
        if name in unknown[:position]:
            raise InputError(
                f"`{name}` stands twice", where=where, value=", ".join(unknown),
                limit="every name once", remedy="remove one of the two",
            )  # fmt: skip


def _check_quantity(name: object, where: str) -> None:
    if name not in QUANTITIES:
        raise InputError(
            "unknown quantity", where=where, value=shown(name), limit=", ".join(QUANTITIES),
            remedy="use one of these names",
        )  # fmt: skip


def _check_null(scene: Scene, where: str) -> None:
    for place, value, names in (
        ("material.conductivity", scene.material.conductivity, ("conductivity", "diffusivity")),
        ("surface_exchange.convection", scene.convection, ("convection", "scaled_convection")),
        ("surface_exchange.emissivity", scene.emissivity, ("emissivity", "scaled_emissivity")),
    ):
        if value is None and not set(names) & set(scene.unknown):
            raise InputError(
                f"`{place}` is null but is not to be found", where=f"{where}: {place}",
                value=f"null, with unknown = [{', '.join(scene.unknown)}]",
                limit=f"a number, or null where `unknown` names {' or '.join(names)}",
                remedy=f"give its value, or add `{names[0]}` to `unknown`",
            )  # fmt: skip


def _exchange(
    convection: object, emissivity: object, where: str
) -> tuple[float | None, float | None]:
    if convection is not None:
        convection = check_number(
            convection, where=f"{where}: surface_exchange.convection",
            quantity="convection coefficient [W/m2/K]", least=0.0,
            remedy="give W/m2/K, at least 0 (still air: 3 to 10)",
        )  # fmt: skip
    if emissivity is not None:
        emissivity = check_number(
            emissivity, where=f"{where}: surface_exchange.emissivity",
            quantity="emissivity", least=0.0, most=1.0,
            remedy="give a fraction from 0 to 1, not per cent",
        )  # fmt: skip
    return convection, emissivity


def _deviation(name: str, value: object, where: str) -> float:
    place = f"{where}: prior.{name}"
    _check_quantity(name, place)
    return check_number(
        value, where=place, quantity="relative standard deviation", above=0.0,
        remedy="give it as a fraction, for example 0.3 for 30 %",
    )  # fmt: skip
