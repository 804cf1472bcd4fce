"""Frames from a file of named arrays, as NPZ and HDF5 are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

import numpy as np

from thermo.errors import InputError
from thermo.imaging._frames import Frames
from thermo.observe import real_array

from ._stated import Stated
from ._values import frames_of, unit_named

FRAMES: Final = ("frames", "temperature")
"""Names of the values; those called `temperature` are kelvin unless a unit is named."""


@final
@dataclass(frozen=True)
class NamedArrays:
    """What a file holds: its `path`, the `names` of its arrays, and how one is read."""

    path: Path
    names: tuple[str, ...]
    read: Callable[[str], np.ndarray]

    def frames_name(self) -> str:
        """The name of the array of frames; `InputError` unless there is just one."""
        found = [name for name in FRAMES if name in self.names]
        if len(found) != 1:
            raise InputError(
                "no array of frames" if not found else "two arrays of frames",
                where=str(self.path), value=f"arrays {', '.join(self.names) or '(none)'}",
                limit="one of `frames` and `temperature`, (frames, rows, columns); optional "
                "`time` [s], `valid`, `unit`",
                remedy="store the frames under one of these names",
            )  # fmt: skip
        return found[0]


def frames_from(arrays: NamedArrays, given: Stated, *, unit: str | None) -> Frames:
    """Frames [K] or [1] and times [s] of a file of named arrays, by the `unit` that it names.

    Raises `InputError`.
    """
    path = arrays.path
    name = arrays.frames_name()
    time = None
    if "time" in arrays.names:
        time = real_array(arrays.read("time"), where=f"{path}: time", quantity="time [s]")
    said = None if unit is None else unit_named(unit, where=f"{path}: unit")
    if said is None and name == "temperature" and given.unit is None:
        said = "K"
    valid = None
    if "valid" in arrays.names:
        valid = _truth(arrays.read("valid"), path)
    values = arrays.read(name)
    if time is not None and time.ndim != 1:
        raise InputError(
            "times are not one a frame", where=f"{path}: time", value=f"shape {time.shape}",
            limit="shape (frames,)", remedy="store one number of seconds a frame",
        )  # fmt: skip
    return frames_of(values, given, where=str(path), unit=said, stamps=time, valid=valid)


def _truth(array: np.ndarray, path: Path) -> np.ndarray:
    whole = array.dtype.kind in "iu" and bool(np.isin(array, (0, 1)).all())
    if array.dtype.kind != "b" and not whole:
        raise InputError(
            "valid is neither true nor false", where=f"{path}: valid", value=f"type {array.dtype}",
            limit="true or false, or 1 and 0", remedy="store true where a pixel may be used",
        )  # fmt: skip
    return array.astype(bool, copy=False)
