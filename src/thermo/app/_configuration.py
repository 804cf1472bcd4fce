"""From a configuration to objects: only what stands in these tables can be built."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from thermo.errors import InputError
from thermo.inverse import (
    Adam,
    GaussNewtonKrylov,
    LevenbergMarquardt,
    LimitedMemoryBfgs,
    Meshing,
    Network,
    OnControlPoints,
    Patchwise,
    Prior,
    Stepping,
    Uniform,
)
from thermo.physics.integrators import BackwardEuler, Sdirk2

Section = Mapping[str, Any]

FIELDS: Mapping[str, Callable[..., Any]] = {
    "uniform": Uniform,
    "patchwise": Patchwise,
    "control_points": OnControlPoints,
    "network": Network,
}
OPTIMISERS: Mapping[str, Callable[..., Any]] = {
    "lm": LevenbergMarquardt,
    "gauss_newton": GaussNewtonKrylov,
    "lbfgs": LimitedMemoryBfgs,
    "adam": Adam,
}
INTEGRATORS: Mapping[str, Callable[..., Any]] = {
    "backward_euler": BackwardEuler,
    "sdirk2": Sdirk2,
}


def _build(group: str, table: Mapping[str, Callable[..., Any]], section: Section) -> Any:
    values = dict(section)
    kind = values.pop("kind", None)
    if kind not in table:
        raise InputError(
            f"there is no such {group}",
            where=f"{group}.kind",
            value=kind,
            limit=", ".join(table),
            remedy=f"give {group}=NAME with one of these names",
        )
    for name, value in values.items():
        positive = isinstance(value, bool | dict) or value > 0
        if not positive and not (name == "octaves" and value == 0):
            raise InputError(
                "a setting is not positive",
                where=f"{group}.{name}",
                value=value,
                limit="a number above 0",
                remedy=f"leave {group}.{name} at its default",
            )
    try:
        return table[kind](**values)
    except TypeError as fault:
        raise InputError(
            "unknown setting", where=group, value=str(fault), limit="the keys in conf/" + group,
            remedy="remove the key",
        ) from fault  # fmt: skip


def build_field(section: Section) -> Any:
    """The field choice of a configuration. Raises `InputError`."""
    return _build("field", FIELDS, section)


def build_optimiser(section: Section) -> Any:
    """The optimiser of a configuration. Raises `InputError`."""
    return _build("optimiser", OPTIMISERS, section)


def build_stepping(section: Section) -> Stepping:
    """The integrator and its steps. Raises `InputError`."""
    values = dict(section)
    integrator = _build("integrator", INTEGRATORS, {"kind": values.pop("kind", None)})
    plain = _build("integrator", {"steps": Stepping}, {"kind": "steps", **values})
    return replace(plain, integrator=integrator)


def build_meshing(section: Section) -> Meshing:
    """The meshing of a configuration. Raises `InputError`."""
    values = dict(section)
    cache = values.pop("cache", None)
    plain = _build("mesh", {"mesh": Meshing}, {"kind": "mesh", **values})
    return replace(plain, cache=None if cache is None else Path(cache))


def build_prior(section: Section) -> Prior:
    """The prior of a configuration. Raises `InputError`."""
    step, decay = float(section["step"]), float(section["decay"])
    if not (step > 0 and decay >= 0):
        raise InputError(
            "the prior makes no sense", where="prior", value=f"step {step}, decay {decay}",
            limit="step above 0, decay not negative", remedy="leave prior at its default",
        )  # fmt: skip
    return Prior(step=step, decay=decay)


def given(section: Section) -> dict[str, float]:
    """The entries of a section that have a value [SI]."""
    return {str(name): float(value) for name, value in section.items() if value is not None}


def names(value: Any, key: str) -> tuple[str, ...] | None:
    """A list of names, or None. Raises `InputError` for anything else."""
    if value is None:
        return None
    if isinstance(value, str) or not all(isinstance(item, str) for item in value):
        raise InputError(
            "a list of names is wanted", where=key, value=value, limit="[a,b]",
            remedy=f"write {key}=[a,b], in quotes if the shell minds brackets",
        )  # fmt: skip
    return tuple(value)
