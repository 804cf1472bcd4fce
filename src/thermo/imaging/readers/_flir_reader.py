"""Radiometric JPEG of FLIR cameras, one or a folder of them."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.imaging._frames import Frames

from ._closed import check_no_dji
from ._damaged import damaged, library
from ._exif_time import exif_time
from ._folder import first_bytes, frame_files, is_kind, stacked, timed
from ._reader import AbstractReader
from ._stated import Stated
from ._values import frames_of

_SUFFIXES = (".jpg", ".jpeg", ".rjpg")
_JPEG = b"\xff\xd8\xff"
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
        """By suffix, or by the first bytes of a JPEG."""
        return is_kind(path, _SUFFIXES) or first_bytes(path, 3) == _JPEG

    def read(self, path: Path, given: Stated) -> Frames:
        """The frames [K] or [1] and their times [s]; raises `InputError`."""
        library("flyr", path)
        files, times = [path], None
        if path.is_dir():
            files, times = timed(path, frame_files(path, _SUFFIXES))
        stamps: list[float | None] = []

        def one(file: Path) -> np.ndarray:
            content = file.read_bytes()
            stamps.append(exif_time(content))
            return _values(file, content, given)

        values = stacked(files, one)
        if times is None:
            times = _dates(stamps)
        unit = "counts" if given.unit == "counts" else "K"
        names = [file.name for file in files] if path.is_dir() else ()
        return frames_of(values, given, where=str(path), unit=unit, stamps=times, names=names)


def _dates(stamps: list[float | None]) -> Float[np.ndarray, " frames"] | None:
    known = [stamp for stamp in stamps if stamp is not None]
    if len(known) < len(stamps):
        return None
    dates = np.array(known)
    whole = bool((dates == np.round(dates)).all())
    # Whole seconds that repeat are too coarse to be times of frames.
    return None if whole and (np.diff(dates) == 0).any() else dates


def _values(path: Path, content: bytes, given: Stated) -> np.ndarray:
    check_no_dji(path, content)
    if not content.startswith(_JPEG):
        raise damaged(path, "JPEG file", "another beginning")
    if b"FLIR\x00" not in content:
        raise InputError(
            "no radiometric header", where=str(path), value="a JPEG without data of a FLIR camera",
            limit="a radiometric JPEG as the camera stored it",
            remedy="copy it from the camera unchanged: programs that edit or send pictures drop "
            "its temperatures; take photographs out of the folder",
        )  # fmt: skip
    thermogram, signal = _unpacked(path, content)
    if given.unit == "counts":
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
