"""From a configuration to objects: only what stands in these tables can be built."""

from __future__ import annotations

import inspect
import math
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
    TwoMaterials,
    Uniform,
)
from thermo.physics.integrators import BackwardEuler, Sdirk2

Section = Mapping[str, Any]

FIELDS: Mapping[str, Callable[..., Any]] = {
    "uniform": Uniform,
    "patchwise": Patchwise,
    "control_points": OnControlPoints,
    "network": Network,
    "two_materials": TwoMaterials,
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


CHOICES = {"order": (1, 2), "coarse_tangents": (True, False)}
STAGES = ("none", "tet4_tet10")
SIZES = ("quick", "full")


def _build(group: str, table: Mapping[str, Callable[..., Any]], section: Section) -> Any:
    values = dict(section)
    kind = values.pop("kind", None)
    if not isinstance(kind, str) or kind not in table:
        raise InputError(
            f"there is no such {group}",
            where=f"{group}.kind",
            value=kind,
            limit=", ".join(table),
            remedy=f"give {group}=NAME with one of these names",
        )
    known = inspect.signature(table[kind]).parameters
    for name, value in values.items():
        if name not in known:
            raise InputError(
                "unknown setting",
                where=f"{group}.{name}",
                value=value,
                limit=", ".join(known) or "no setting at all",
                remedy=f"remove {group}.{name}",
            )
        for item in value.values() if isinstance(value, Mapping) else (value,):
            _check_setting(f"{group}.{name}", item, known[name].default, name)
    return table[kind](**values)


def _check_setting(where: str, value: Any, default: Any, name: str) -> None:
    if value is None and default is None:
        return
    limit = "a number above 0"
    if isinstance(default, bool):
        limit, fine = "true or false", isinstance(value, bool)
    elif name in CHOICES:
        limit, fine = " or ".join(map(str, CHOICES[name])), value in CHOICES[name]
    elif isinstance(value, bool) or not isinstance(value, int | float):
        fine = False
    elif isinstance(default, int) and not isinstance(value, int):
        limit, fine = "a whole number above 0", False
    else:
        fine = 0 < value < float("inf") or (name == "octaves" and value == 0)
    if not fine:
        raise InputError(
            "a setting makes no sense",
            where=where,
            value=value,
            limit=limit,
            remedy=f"leave {where} at its default",
        )


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
    step = None if section["step"] is None else number(section, "step", "prior.")
    decay = number(section, "decay", "prior.")
    if not ((step is None or step > 0) and decay >= 0):
        raise InputError(
            "the prior makes no sense", where="prior", value=f"step {step}, decay {decay}",
            limit="step null or above 0, decay not negative", remedy="leave prior at its default",
        )  # fmt: skip
    return Prior(step=step, decay=decay)


def stages(section: Section) -> Any:
    """The name of the stages. Raises `InputError`."""
    if section["kind"] not in STAGES:
        raise InputError(
            "there are no such stages", where="stages.kind", value=section["kind"],
            limit=", ".join(STAGES), remedy="give stages=NAME with one of these names",
        )  # fmt: skip
    return section["kind"]


def size(value: Any) -> Any:
    """The size of a study. Raises `InputError`."""
    if value not in SIZES:
        raise InputError(
            "a study has no such size", where="size", value=value, limit=", ".join(SIZES),
            remedy=f"give size={SIZES[0]}",
        )  # fmt: skip
    return value


def number(
    section: Section, key: str, prefix: str = "", *, whole: bool = False, above: float = -math.inf
) -> Any:
    """A number of a section, in that setting's unit. Raises `InputError` for anything else."""
    value = section[key]
    kinds = int if whole else int | float
    plain = isinstance(value, kinds) and not isinstance(value, bool) and math.isfinite(value)
    if not (plain and value > above):
        least = "" if above == -math.inf else f" above {above:g}"
        if whole and above > -math.inf:
            least = f", {above + 1:g} or more"
        raise InputError(
            "a number is wanted", where=prefix + key, value=value,
            limit=("a whole number" if whole else "a finite number") + least,
            remedy=f"give {prefix}{key} such a number, or leave it at its default",
        )  # fmt: skip
    return value if whole else float(value)


def flag(section: Section, key: str, prefix: str = "") -> bool:
    """True or false of a section. Raises `InputError` for anything else."""
    value = section[key]
    if not isinstance(value, bool):
        raise InputError(
            "this is neither yes nor no", where=prefix + key, value=value, limit="true or false",
            remedy=f"give {prefix}{key}=true or {prefix}{key}=false",
        )  # fmt: skip
    return value


def given(section: Section, prefix: str) -> dict[str, float]:
    """The entries of a section that have a value [SI]. Raises `InputError` for other than numbers.

    Arguments: `prefix`: the section's name and a dot.
    """
    present = [str(name) for name, value in section.items() if value is not None]
    return {name: number(section, name, prefix) for name in present}


def names(value: Any, key: str) -> tuple[str, ...] | None:
    """A list of names, or None. Raises `InputError` for anything else."""
    if value is None:
        return None
    if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
        meant = value if isinstance(value, str) else "a,b"
        raise InputError(
            "a list of names is wanted", where=key, value=value, limit="[a,b]",
            remedy=f"write {key}=[{meant}], in quotes if the shell minds brackets",
        )  # fmt: skip
    return tuple(value)
