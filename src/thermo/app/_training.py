"""The training that a configuration asks for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from thermo.app._configuration import number
from thermo.errors import InputError
from thermo.reconstruct import Balance, Sampling, Training

_COUNTS = ("steps", "rays", "features", "width", "told", "warm")
_PLACES = ("search", "rounds", "sections")


def build_training(section: Mapping[str, Any], seed: int) -> Training:
    """Sizes and rates of the group `training`.

    Arguments: `seed`: of all that is drawn [1].

    Raises `InputError` for values that make no sense.
    """
    known = {*_COUNTS, *_PLACES, "cells", "rate", "opened", "eikonal", "mask", "anywhere"}
    for name in set(section) - known:
        raise InputError(
            "unknown setting", where=f"training.{name}", value=section[name],
            limit=", ".join(sorted(known)), remedy=f"remove training.{name}",
        )  # fmt: skip

    def whole(name: str) -> int:
        return number(section, name, "training.", whole=True, above=0)

    return Training(
        **{name: whole(name) for name in _COUNTS},
        cells=_cells(section["cells"]),
        rate=number(section, "rate", "training.", above=0.0),
        opened=number(section, "opened", "training.", above=0.0),
        sampling=Sampling(**{name: whole(name) for name in _PLACES}),
        balance=Balance(
            eikonal=number(section, "eikonal", "training.", above=0.0),
            mask=number(section, "mask", "training.", above=0.0),
            anywhere=whole("anywhere"),
        ),
        seed=seed,
    )


def _cells(value: Any) -> tuple[int, ...]:
    fine = (
        isinstance(value, list)
        and bool(value)
        and all(isinstance(one, int) and not isinstance(one, bool) for one in value)
        and all(2 <= one <= 256 for one in value)
        and sorted(value) == value
    )
    if not fine:
        raise InputError(
            "these grids make no sense", where="training.cells", value=value,
            limit="whole numbers from 2 to 256, coarse to fine",
            remedy="give cells as [16,32,64]",
        )  # fmt: skip
    return tuple(value)
