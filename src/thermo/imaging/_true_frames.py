"""Whole recordings brought to true temperatures."""

from __future__ import annotations

import numpy as np

from thermo.errors import InputError
from thermo.observe import COLDEST, HOTTEST

from ._frames import Frames
from ._optics import Optics, together
from ._radiometry import gain_and_rest
from ._response import AbstractResponse


def to_temperature(
    frames: Frames, response: AbstractResponse, optics: Optics, *, where: str = "frames"
) -> Frames:
    """Frames of true temperatures [K] from counts or from apparent temperatures.

    Arguments:

    - `frames`: the sensor's signal in the unit of `response` where they are `counts`, else what a
      camera set to emissivity 1 and transmission 1 reads [K].
    - `response`: of the camera; for counts it has to be the calibration of this camera.
    - `optics`: numbers, or one value a pixel, (rows, columns).
    - `where`: what messages call the frames.

    Pixels without a temperature between 150 K and 5000 K become NaN and not valid.

    Raises `InputError` where the shapes differ, and where more than half of the valid values, of
    those whose emissivity is known, have no temperature.
    """
    rows_columns = frames.size()
    if together(optics.shape(), rows_columns) != rows_columns:
        raise InputError(
            "optics and frames differ in shape", where=where,
            value=f"frames of {rows_columns} pixels, optics of shape {optics.shape()}",
            limit="one number, or an array of the frames' rows and columns",
            remedy="draw the emissivity on a frame of this camera",
        )  # fmt: skip
    gain, rest = gain_and_rest(response, optics)
    known = np.broadcast_to(~np.isnan(optics.emissivity), rows_columns)
    kelvin = np.empty_like(frames.values)
    asked = lost = 0
    for image, valid, out in zip(frames.values, frames.valid, kelvin, strict=True):
        read = image.astype(np.float64)
        signal = read if frames.counts else response.signal(read)
        found = response.temperature(np.asarray((signal - rest) / gain))
        out[:] = np.where((found >= COLDEST) & (found <= HOTTEST), found, np.nan)
        asked += int((valid & known).sum())
        lost += int((valid & known & np.isnan(out)).sum())
    if 2 * lost > asked:
        raise _hopeless(frames, response, where, lost, asked)
    return Frames(
        frames.time, kelvin, frames.valid & ~np.isnan(kelvin), counts=False, where=where
    )  # fmt: skip


def _hopeless(
    frames: Frames, response: AbstractResponse, where: str, lost: int, asked: int
) -> InputError:
    low, high = response.signal(np.array([COLDEST, HOTTEST]))
    read = np.median(frames.values[frames.valid])
    value = f"{lost} of {asked} valid values have none; the median reads {read:g}"
    if frames.counts:
        return InputError(
            "most of these counts have no temperature", where=where, value=value,
            limit=f"after reflections and air are taken off, {low:g} ({COLDEST:g} K) to "
            f"{high:g} ({HOTTEST:g} K)",
            remedy="take the calibration of this very camera and range; look for swapped bytes in "
            "the counts, an emissivity that is too low and surroundings that are too hot",
        )  # fmt: skip
    return InputError(
        "most of these readings have no true temperature", where=where, value=f"{value} K",
        limit=f"more than reflections, air and window give alone; {COLDEST:g} K to {HOTTEST:g} K",
        remedy="the emissivity is too low or the reflected temperature too high; give frames as "
        "read at emissivity 1, or none that the camera has corrected already",
    )  # fmt: skip
