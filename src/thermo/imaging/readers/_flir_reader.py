"""Radiometric JPEG of FLIR cameras, one or a folder of them."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from thermo.errors import InputError
from thermo.imaging._frames import Frames

from ._damaged import damaged, library
from ._jpeg import is_jpeg, is_of_dji, jpeg_frames
from ._reader import AbstractReader
from ._stated import Stated

_POSITIVE: Final = ("planck_r1", "planck_r2", "planck_b", "ir_window_transmission")


@final
class FlirReader(AbstractReader):
    """Radiometric JPEG of FLIR: temperatures [K] by the settings in each file.

    Emissivity, reflected temperature, distance, air and window are those that the file holds, and
    the camera's Planck constants turn the signal into kelvin. Stating `unit` = "counts" gives the
    signal itself [1]. Times are the dates in the files; where those are whole seconds that repeat,
    state `rate`.
    """

    def format(self) -> str:
        """The files that it reads."""
        return "radiometric JPEG of FLIR (one, or a folder of them)"

    def recognises(self, path: Path) -> bool:
        """By suffix, or by the first bytes of a JPEG, unless it is of DJI's own format."""
        return is_jpeg(path) and not is_of_dji(path)

    def read(self, path: Path, given: Stated) -> Frames:
        """The frames [K] or [1] and their times [s]; raises `InputError`."""
        library("flyr", path)
        unit = "counts" if given.unit == "counts" else "K"
        return jpeg_frames(
            path, lambda file, content: _values(file, content, unit), given, unit=unit
        )  # fmt: skip


def _values(path: Path, content: bytes, unit: str) -> np.ndarray:
    if b"FLIR\x00" not in content:
        raise InputError(
            "no radiometric header", where=str(path), value="a JPEG without data of a FLIR camera",
            limit="a radiometric JPEG as the camera stored it",
            remedy="copy it from the camera unchanged: programs that edit or send pictures drop "
            "its temperatures; take photographs out of the folder",
        )  # fmt: skip
    thermogram, signal = _unpacked(path, content)
    if unit == "counts":
        return signal
    _check_settings(path, thermogram.metadata)
    try:
        with np.errstate(all="ignore"):
            kelvin = thermogram.kelvin
    except (ValueError, ZeroDivisionError, OverflowError) as error:
        raise damaged(path, "radiometric header of FLIR", error) from error
    return np.where(np.isfinite(kelvin), kelvin, np.nan).astype(np.float32)


def _unpacked(path: Path, content: bytes) -> tuple[Any, np.ndarray]:
    image, flyr = library("PIL.Image", path), library("flyr", path)
    records, thermal = library("flyr.records", path), library("flyr.thermal", path)
    try:
        with image.open(io.BytesIO(content)) as picture:
            picture.load()  # the temperatures stand in front of the picture: is the rest there?
        stream = records.extract_flir_app1(io.BytesIO(content))
        place = records.parse_flir_records(stream)[records.RecordIndex.RAW_DATA.value]
        _, _, signal = thermal.parse_raw_data(stream, place)
        return flyr.unpack(io.BytesIO(content)), np.asarray(signal).astype(np.uint16)
    except Exception as error:  # the library lets out whatever its parsing meets
        raise damaged(path, "radiometric JPEG of FLIR", error) from error


def _check_settings(path: Path, settings: Mapping[str, float]) -> None:
    wrong = [key for key in _POSITIVE if not settings[key] > 0]
    if not 0 < settings["emissivity"] <= 1:
        wrong.append("emissivity")
    if wrong:
        raise InputError(
            "the radiometric header is wrong", where=str(path),
            value=f"{wrong[0]} = {settings[wrong[0]]:g}",
            limit="positive constants of Planck's law, emissivity above 0 and at most 1",
            remedy="copy the file from the camera again; or state recording.unit=counts and "
            "calibrate the signal by a radiometry of your own",
        )  # fmt: skip
