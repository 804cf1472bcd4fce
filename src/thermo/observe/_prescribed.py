"""Measured temperature histories that are prescribed on a part of the surface."""

from __future__ import annotations

from pathlib import Path
from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from thermo.errors import InputError

from ._box import Box
from ._csv_table import TEMPERATURE, TIME, read_table
from ._kelvin import check_kelvin
from ._npz import read_npz
from ._number import real_array
from ._recording import check_time


@final
class Prescribed(eqx.Module):
    """A temperature history that holds for all surface nodes inside a box.

    Arguments:

    - `box_min`, `box_max`: opposite corners of the box, (3,) [m]; its faces count as inside.
    - `time`: (history,) [s], increasing.
    - `temperature`: (history,) [K], without gaps; linear in between, constant outside.
    - `where`: what messages call this history.

    Raises `InputError` for a box that is inside out, shapes that do not fit, time that does not
    increase, missing values, and temperatures that cannot be kelvin.
    """

    box_min: Float[np.ndarray, "3"]
    box_max: Float[np.ndarray, "3"]
    time: Float[np.ndarray, " history"]
    temperature: Float[np.ndarray, " history"]

    def __init__(
        self,
        box_min: ArrayLike,
        box_max: ArrayLike,
        time: ArrayLike,
        temperature: ArrayLike,
        *,
        where: str = "prescribed",
    ) -> None:
        box = Box(box_min, box_max, where=f"{where}.box")
        self.box_min, self.box_max = box.low, box.high
        self.time = check_time(time, where=f"{where}.time", earliest=None)
        self.temperature = _history(temperature, self.time.size, f"{where}.temperature")

    def box(self) -> Box:
        """Where it holds [m]."""
        return Box(self.box_min, self.box_max)


def read_history(
    path: Path | str,
) -> tuple[Float[np.ndarray, " history"], Float[np.ndarray, " history"]]:
    """Read a temperature history: its times [s] and temperatures [K].

    An NPZ holds `time` and `temperature`, both (history,); a CSV has the columns `time` and
    `temperature`, with units in the header as in `read_recording`.

    Raises `InputError` if the file is absent, damaged, or holds what `Prescribed` refuses.
    """
    file = Path(path)
    if file.suffix.lower() == ".npz":
        arrays = read_npz(file, required=("time", "temperature"))
        return _checked(arrays["time"], arrays["temperature"], str(file))
    table = read_table(file)
    bases = table.bases({"time": TIME, "temperature": TEMPERATURE})
    if sorted(bases) != ["temperature", "time"]:
        raise InputError(
            "columns are not those of a history", where=str(file),
            value=", ".join(table.header), limit="the two columns time and temperature",
            remedy="name them `time` and `temperature` (units as in `time_s`, `temperature_C`)",
        )  # fmt: skip
    time = table.numbers(bases["time"], TIME)
    return _checked(time, table.numbers(bases["temperature"], TEMPERATURE), str(file))


def _checked(time: object, temperature: object, file: str) -> tuple[np.ndarray, np.ndarray]:
    seconds = check_time(time, where=f"{file}: time", earliest=None)
    return seconds, _history(temperature, seconds.size, f"{file}: temperature")


def _history(temperature: object, frames: int, where: str) -> np.ndarray:
    values = real_array(temperature, where=where, quantity="temperature history [K]")
    if values.shape != (frames,) or np.isnan(values).any():
        gaps = int(np.isnan(values).sum())
        raise InputError(
            "history does not fit its times", where=where,
            value=f"shape {values.shape}, {gaps} missing values",
            limit=f"shape ({frames},), one temperature a time, none missing",
            remedy="give as many temperatures as times; leave out the times without a value",
        )  # fmt: skip
    check_kelvin(values, where=where)
    return values
