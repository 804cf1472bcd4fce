"""A property of the material at some temperatures."""

from __future__ import annotations

from dataclasses import InitVar, dataclass
from typing import Final, final

import numpy as np

from thermo.errors import InputError

from ._kelvin import check_kelvin_number
from ._number import real_array, shown

REFERENCE: Final = 293.15
"""Temperature [K] at which a property that changes with it has the value that stands for it."""


@final
@dataclass(frozen=True)
class TemperatureTable:
    """A property that is known at some temperatures, linear in between and constant outside.

    Arguments:

    - `temperature`: (points,) two or more, increasing [K].
    - `value`: (points,), above 0, in the property's unit: [J/kg/K] or [W/m/K].
    - `where`: what messages call this table.

    Raises `InputError` for temperatures that cannot be kelvin or do not increase, for values that
    are not above 0, and for shapes that do not fit.
    """

    temperature: tuple[float, ...]
    value: tuple[float, ...]
    where: InitVar[str] = "table"

    def __post_init__(self, where: str) -> None:
        at = _column(self.temperature, f"{where}.temperature", "temperature [K]")
        value = _column(self.value, f"{where}.value", "value of the property")
        for one in at.tolist():
            check_kelvin_number(one, where=f"{where}.temperature", quantity="temperature")
        if len(at) < 2:
            raise InputError(
                "a table of one temperature or none", where=f"{where}.temperature", value=shown(at),
                limit="two or more", remedy="write a property that does not change as a number",
            )  # fmt: skip
        if not np.all(np.diff(at) > 0):
            raise InputError(
                "temperatures of a table do not increase", where=f"{where}.temperature",
                value=shown(at), limit="each above the one before",
                remedy="sort the table by temperature, each of them once",
            )  # fmt: skip
        if value.shape != at.shape:
            raise InputError(
                "table does not fit its temperatures", where=f"{where}.value",
                value=f"{len(value)} values", limit=f"{len(at)}, one a temperature",
                remedy="give as many values as temperatures",
            )  # fmt: skip
        wrong = np.flatnonzero(~(np.isfinite(value) & (value > 0)))
        if len(wrong):
            raise InputError(
                "a value of the property is out of range", where=f"{where}.value[{wrong[0]}]",
                value=f"{value[wrong[0]]:g} at {at[wrong[0]]:g} K", limit="finite and above 0",
                remedy="give the property itself at each temperature, in SI units",
            )  # fmt: skip
        # Tuples of floats compare, hash and print in full.
        object.__setattr__(self, "temperature", tuple(at.tolist()))
        object.__setattr__(self, "value", tuple(value.tolist()))

    def at(self, temperature: float = REFERENCE) -> float:
        """The property, in its unit, at a temperature [K]."""
        return float(np.interp(temperature, self.temperature, self.value))


def _column(values: object, where: str, quantity: str) -> np.ndarray:
    array = real_array(values, where=where, quantity=quantity)
    if array.ndim != 1:
        raise InputError(
            f"{quantity} is no list of numbers", where=where, value=shown(array),
            limit="a list of numbers", remedy="write it as [first, second, ...]",
        )  # fmt: skip
    return array
