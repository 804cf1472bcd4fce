"""What a user states about frames whose file does not say it."""

from __future__ import annotations

from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from thermo.errors import InputError
from thermo.observe import check_number, check_time

UNITS: Final = ("K", "C", "counts")
"""What values can be in: kelvin, degrees Celsius, or the sensor's own signal."""


@final
class Stated(eqx.Module):
    """What is stated about a camera's file; all of it may be left out.

    Arguments:

    - `rate`: frames a second [Hz], used where the file has no time stamps.
    - `times`: of the frames, (frames,) [s], used in place of the file's stamps. The run starts at
      0, frames before it are quiet ones.
    - `start`: time of the first frame [s]; the file's stamps are shifted to it. Where it is left
      out, stamps stand as they are, and a calendar's stamps begin at 0.
    - `unit`: "K", "C" or "counts" of the values, where the file does not say it. Of a format that
      stores both, "counts" asks for the sensor's signal.
    - `scale` [K] and `offset` [K]: temperature = scale * value + offset, in `unit`, for whole
      numbers that stand for temperatures, as in files of centikelvin.
    - `where`: what messages call it.

    Raises `InputError` for values out of range and for statements that exclude each other.
    """

    rate: float | None
    times: Float[np.ndarray, " frames"] | None
    start: float | None
    unit: str | None = eqx.field(static=True)
    scale: float | None
    offset: float | None

    def __init__(
        self,
        *,
        rate: object = None,
        times: ArrayLike | None = None,
        start: object = None,
        unit: str | None = None,
        scale: object = None,
        offset: object = None,
        where: str = "settings of the frames",
    ) -> None:
        self.rate = _number(rate, f"{where}: rate", "frames a second [Hz]", above=0.0)
        self.start = _number(start, f"{where}: start", "time of the first frame [s]")
        self.scale = _number(scale, f"{where}: scale", "kelvin a count [K]", above=0.0)
        self.offset = _number(offset, f"{where}: offset", "temperature at 0 counts [K]")
        self.times = (
            None
            if times is None
            else check_time(times, where=f"{where}: times", earliest=None, least_frames=1)
        )
        if unit is not None and unit not in UNITS:
            raise InputError(
                "values have no such unit", where=f"{where}: unit", value=repr(unit),
                limit=", ".join(UNITS), remedy="convert the values, or name one of these units",
            )  # fmt: skip
        self.unit = unit
        _agree(self.times is not None and self.rate is not None, where, "times", "rate")
        _agree(self.times is not None and self.start is not None, where, "times", "start")
        _agree(self.scaled() and unit == "counts", where, "scale or offset", "unit = counts")

    def scaled(self) -> bool:
        """Whether whole numbers are said to stand for temperatures."""
        return self.scale is not None or self.offset is not None


def _number(value: object, where: str, quantity: str, above: float | None = None) -> float | None:
    if value is None:
        return None
    return check_number(
        value, where=where, quantity=quantity, above=above, remedy="correct it, or leave it out"
    )


def _agree(both: bool, where: str, one: str, other: str) -> None:
    if both:
        raise InputError(
            "two statements exclude each other", where=where, value=f"{one} and {other}",
            limit="one of the two", remedy=f"leave out {one} or {other}",
        )  # fmt: skip
