"""Telops recordings (`.hcc`)."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any, Final, final

import numpy as np
from jaxtyping import Float, Shaped

from thermo.imaging._frames import Frames

from ._damaged import damaged, library
from ._reader import AbstractReader
from ._stated import Stated
from ._values import frames_of

_RADIOMETRIC: Final = 2
"""The calibration mode [1] in which values are temperatures."""

_TICK: Final = 1e-7
"""One step of the header's part of a second [s]."""


@final
class HccReader(AbstractReader):
    """Telops `.hcc`: temperatures [K] where the camera was in its radiometric mode, else counts.

    Times are the stamps in the headers, or follow from the rate in the header where there are no
    stamps. Stating `unit` = "counts" gives the stored numbers.
    """

    def format(self) -> str:
        """The files that it reads."""
        return "HCC (Telops)"

    def recognises(self, path: Path) -> bool:
        """By suffix."""
        return path.suffix.casefold() == ".hcc" and not path.is_dir()

    def read(self, path: Path, given: Stated) -> Frames:
        """The frames [K] or [1] and their times [s]; raises `InputError`."""
        fasthcc = library("fasthcc", path)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # it only warns of a file that ends in a frame
                with fasthcc.HCCReader(path) as file:
                    headers = file.read_metadata()
                    values, unit = _values(file, headers, given)
        except (ValueError, OSError, KeyError, MemoryError, Warning) as error:
            raise damaged(path, "HCC file", error) from error
        stamps = _stamps(headers, given)
        return frames_of(values, given, where=str(path), unit=unit, stamps=stamps)


def _values(
    file: Any, headers: list[dict[str, Any]], given: Stated
) -> tuple[Shaped[np.ndarray, "frames rows columns"], str | None]:
    modes = sorted({header["CalibrationMode"] for header in headers})
    if len(modes) > 1:
        raise ValueError(f"calibration modes {modes} in one file")
    # Before version 10 the header tells neither offset nor exponent.
    scaled = modes[0] > 0 and file.header_version[0] >= 10
    if given.unit == "counts" or not scaled:
        return file.read_frames(), "counts"
    # Each frame has an offset and an exponent of its own: they change when a camera recalibrates.
    values = np.empty((file.n_frames, file.height, file.width), np.float32)
    for index, header in enumerate(headers):
        raw = file.read_frames(index, index + 1)[0].astype(np.float64)
        values[index] = raw * 2.0 ** header["DataExp"] + header["DataOffset"]
    return values, None if modes[0] == _RADIOMETRIC else "counts"


def _stamps(headers: list[dict[str, Any]], given: Stated) -> Float[np.ndarray, " frames"] | None:
    first = headers[0].get("POSIXTime", 0)
    if first and all(header.get("POSIXTime", 0) for header in headers):
        # Whole seconds first, so that no digit of the parts is lost.
        return np.array(
            [(one["POSIXTime"] - first) + one["SubSecondTime"] * _TICK for one in headers]
        )
    rate = headers[0]["AcquisitionFrameRate"]
    if given.rate is not None or not rate > 0:
        return None
    return np.arange(len(headers)) / rate
