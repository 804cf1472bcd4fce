"""Checks of single numbers, vectors and arrays that come from a user."""

from __future__ import annotations

import math
from numbers import Real

import numpy as np

from thermo.errors import InputError

_MISSING = "give a finite number; a quantity to be found may be null only where it is in `unknown`"


def check_number(
    value: object,
    *,
    where: str,
    quantity: str,
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
    remedy: str = _MISSING,
) -> float:
    """Return `value` as a float, or refuse it.

    Arguments:

    - `value`: what the user gave.
    - `where`: the file and key, for the message.
    - `quantity`: its name and SI unit, for the message.
    - `above`, `least`, `most`: open lower, closed lower and closed upper limit, in the quantity's
      unit.
    - `remedy`: what the user can do.

    Raises `InputError` if it is no real number, not finite or outside the limits.
    """
    limit = _limit(above, least, most)
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real):
        raise InputError(
            f"{quantity} is not a number", where=where, value=shown(value), limit=limit,
            remedy=remedy,
        )  # fmt: skip
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    inside = (
        math.isfinite(number)
        and (above is None or number > above)
        and (least is None or number >= least)
        and (most is None or number <= most)
    )
    if not inside:
        raise InputError(
            f"{quantity} is out of range", where=where, value=shown(value), limit=limit,
            remedy=remedy,
        )  # fmt: skip
    return number


def check_vector(value: object, *, where: str, quantity: str) -> np.ndarray:
    """Return three finite numbers as an array (3,), or raise `InputError`."""
    vector = real_array(value, where=where, quantity=quantity)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise InputError(
            f"{quantity} is not a vector", where=where, value=shown(value),
            limit="three finite numbers [x, y, z]", remedy="give x, y and z in metres",
        )  # fmt: skip
    return vector


def real_array(value: object, *, where: str, quantity: str) -> np.ndarray:
    """Return `value` as float64 of any shape, in the quantity's unit, or raise `InputError`."""
    try:
        array = np.asarray(value)
    except ValueError:
        array = np.asarray(None)  # a ragged list
    if array.dtype.kind not in "fiu":
        raise InputError(
            f"{quantity} does not hold plain numbers", where=where,
            value=f"{shown(value)} (type {array.dtype})", limit="a rectangular array of numbers",
            remedy="store it as floating-point numbers, rows of equal length, no nulls or text",
        )  # fmt: skip
    return array.astype(np.float64)


def shown(value: object) -> str:
    """Return a short form of `value` that fits on one line of a message."""
    if isinstance(value, np.ndarray):
        return str(value.tolist()) if value.size <= 4 else f"array of shape {value.shape}"
    text = repr(value) if isinstance(value, str) else str(value)
    text = "null" if value is None else " ".join(text.split())
    return text if len(text) <= 90 else text[:87] + "..."


def _limit(above: float | None, least: float | None, most: float | None) -> str:
    parts = ["a finite number"]
    if above is not None:
        parts.append(f"above {above:g}")
    if least is not None:
        parts.append(f"at least {least:g}")
    if most is not None:
        parts.append(f"at most {most:g}")
    return ", ".join(parts)
