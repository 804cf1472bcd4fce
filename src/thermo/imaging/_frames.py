"""Frames of one camera over time."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from thermo.errors import InputError
from thermo.observe import check_kelvin, check_time, real_array


@final
class Frames(eqx.Module):
    """What a camera recorded; all leaves are NumPy arrays.

    Arguments:

    - `time`: of the frames, (frames,) [s], increasing; the run starts at 0, frames before it are
      quiet ones.
    - `values`: what each pixel read, (frames, rows, columns): temperatures [K] or, where `counts`
      says so, the sensor's signal [1]; NaN where there is none. Kept in single precision, which
      holds 0.03 mK at room temperature.
    - `valid`: false where a value must not be used, (frames, rows, columns), (rows, columns) or
      left out. A value that is NaN is never valid.
    - `counts`: whether `values` are the sensor's signal.
    - `where`: what messages call them, usually their file or folder.

    Raises `InputError` for shapes that do not fit, times that do not increase, and temperatures
    that cannot be kelvin.
    """

    time: Float[np.ndarray, " frames"]
    values: Float[np.ndarray, "frames rows columns"]
    valid: Bool[np.ndarray, "frames rows columns"]
    counts: bool = eqx.field(static=True)

    def __init__(
        self,
        time: ArrayLike,
        values: ArrayLike,
        valid: ArrayLike | None = None,
        *,
        counts: bool = False,
        where: str = "frames",
    ) -> None:
        self.time = check_time(time, where=f"{where}: time", earliest=None, least_frames=1)
        self.values = _images(values, where)
        self.counts = counts
        if len(self.values) != len(self.time):
            raise InputError(
                "frames and times differ in number", where=where,
                value=f"{len(self.values)} frames, {len(self.time)} times",
                limit="one time a frame",
                remedy="look for frames that were dropped, or for a header counted as a time",
            )  # fmt: skip
        given = np.ones((), bool) if valid is None else np.asarray(valid)
        if given.dtype != bool or given.shape not in ((), self.values.shape, self.values.shape[1:]):
            raise InputError(
                "valid does not fit the frames", where=f"{where}: valid",
                value=f"shape {given.shape}, type {given.dtype}",
                limit=f"true or false, shape {self.values.shape} or {self.values.shape[1:]}",
                remedy="store true where a pixel may be used",
            )  # fmt: skip
        self.valid = given & ~np.isnan(self.values)
        if not counts:
            check_kelvin(self.values, where=where, used=self.valid)

    def size(self) -> tuple[int, int]:
        """Rows and columns of a frame [px]."""
        return self.values.shape[1], self.values.shape[2]


def _images(values: object, where: str) -> Float[np.ndarray, "frames rows columns"]:
    array = np.asarray(values)
    if array.dtype != np.float32:
        array = real_array(values, where=where, quantity="frames").astype(np.float32)
    if array.ndim != 3 or 0 in array.shape:
        raise InputError(
            "these are no frames", where=where, value=f"shape {array.shape}",
            limit="shape (frames, rows, columns), none of them 0",
            remedy="give one image a time; colours are no temperatures",
        )  # fmt: skip
    return array
