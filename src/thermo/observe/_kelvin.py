"""Absolute temperature: what cannot be kelvin is refused, since radiation needs T^4."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Bool, Float

from thermo.errors import InputError

from ._number import check_number

COLDEST: Final = 150.0
"""Lowest temperature that is believed to be kelvin [K]; room temperature in Celsius is below."""

HOTTEST: Final = 5000.0
"""Highest temperature that is believed to be kelvin [K]; raw camera counts are above."""

_LIMIT = f"kelvin, from {COLDEST:g} to {HOTTEST:g} K"
_CELSIUS = "it looks like degrees Celsius: add 273.15 (in CSV a header as `temperature_C` does)"
_DEAD = "most values are kelvin: mark dead pixels as NaN, or false in the array `valid`"
_COUNTS = "it looks like raw camera counts or scaled integers: convert to kelvin"


def check_kelvin_number(value: object, *, where: str, quantity: str) -> float:
    """Return one absolute temperature [K], or raise `InputError` naming `where`."""
    return check_number(
        value, where=where, quantity=f"{quantity} [K]", least=COLDEST, most=HOTTEST,
        remedy=f"give it in kelvin; if it is in degrees Celsius, add {273.15}",
    )  # fmt: skip


def check_kelvin(
    values: Float[np.ndarray, "..."], *, where: str, used: Bool[np.ndarray, "..."] | None = None
) -> None:
    """Refuse temperatures that are infinite or cannot be kelvin.

    Arguments:

    - `values`: temperatures [K]; NaN is a missing value and passes.
    - `where`: the file and key, for the message.
    - `used`: true where a value counts; all of them where it is left out.

    Raises `InputError` with the worst value and its place.
    """
    counts = ~np.isnan(values) if used is None else used & ~np.isnan(values)
    infinite = counts & np.isinf(values)
    if infinite.any():
        raise InputError(
            "infinite temperature", where=where,
            value=f"{int(infinite.sum())} infinite values, the first {_place(infinite)}",
            limit=f"{_LIMIT}; NaN where a value is missing",
            remedy="replace infinite values by NaN, or mark them false in the array `valid`",
        )  # fmt: skip
    for wrong, pick in (
        (counts & (values < COLDEST), np.min),
        (counts & (values > HOTTEST), np.max),
    ):
        if wrong.any():
            worst = float(pick(values[wrong]))
            raise InputError(
                "temperature that cannot be kelvin", where=where,
                value=f"{worst:g} ({int(wrong.sum())} of {int(counts.sum())} values outside, "
                f"the first {_place(wrong)})",
                limit=_LIMIT, remedy=_remedy(values[counts], worst),
            )  # fmt: skip


def _remedy(values: np.ndarray, worst: float) -> str:
    if COLDEST <= np.median(values) <= HOTTEST:
        return _DEAD
    return _CELSIUS if worst < COLDEST else _COUNTS


def _place(wrong: np.ndarray) -> str:
    index = np.argwhere(wrong)[0].tolist()
    names = ("frame", "sample") if len(index) == 2 else ("entry",)
    return "at " + ", ".join(f"{name} {i}" for name, i in zip(names, index, strict=False))
