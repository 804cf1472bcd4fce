"""TIFF: a stack of frames, or a folder of single ones."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, final

import numpy as np

from thermo.errors import InputError
from thermo.imaging._frames import Frames

from ._damaged import damaged, library
from ._folder import first_bytes, is_kind, single_frames
from ._reader import AbstractReader
from ._stated import Stated
from ._values import frames_of

_SUFFIXES = (".tif", ".tiff", ".btf")
_MAGIC = (b"II*\x00", b"MM\x00*", b"II+\x00", b"MM\x00+")


@final
class TiffReader(AbstractReader):
    """TIFF of one channel: 16-bit counts or scaled temperatures, or floating-point temperatures.

    A folder's files are taken in the order of the numbers in their names, or by `times.csv`. Whole
    numbers are counts unless `scale` and `offset`, or a unit, are stated. TIFF holds no stamps
    that are fine enough: state `rate` or `times`.
    """

    def format(self) -> str:
        """The files that it reads."""
        return "TIFF (16 or 32 bits, a stack or a folder of single frames)"

    def recognises(self, path: Path) -> bool:
        """By suffix, or by the first bytes."""
        return is_kind(path, _SUFFIXES) or first_bytes(path, 4) in _MAGIC

    def read(self, path: Path, given: Stated) -> Frames:
        """The frames [K] or [1] at stated times [s]; raises `InputError`."""
        library("tifffile", path)
        if not path.is_dir():
            return frames_of(_read(path), given, where=str(path))
        return single_frames(path, _SUFFIXES, _read, given)


def _read(path: Path) -> np.ndarray:
    tifffile = library("tifffile", path)
    try:
        with _complaints(tifffile) as complaints, tifffile.TiffFile(path) as file:
            series = list(file.series)
            _check_series(path, series)
            values = series[0].asarray()
    except InputError:
        raise
    except ValueError as error:
        if "imagecodecs" in str(error):
            raise _packed(path, error) from error
        raise damaged(path, "TIFF file", error) from error
    except Exception as error:  # tifffile lets out whatever a hostile file provokes
        raise damaged(path, "TIFF file", error) from error
    if complaints:
        raise damaged(path, "TIFF file", complaints[0])
    return values.squeeze() if values.ndim > 3 else values


def _check_series(path: Path, series: list[Any]) -> None:
    sizes = [" x ".join(str(n) for n in one.shape[::-1]) + " px" for one in series]
    if len(set(sizes)) > 1:
        raise InputError(
            "images of different sizes in one file", where=str(path), value="; ".join(sizes[:4]),
            limit="frames of one size", remedy="export the frames without previews",
        )  # fmt: skip
    if len(series) != 1 or "S" in series[0].axes:
        raise InputError(
            "these are no frames of one channel", where=str(path),
            value=f"{len(series)} series" + (f", axes {series[0].axes}" if series else ""),
            limit="one stack of images (frames, rows, columns)",
            remedy="give one image a time; colours are no temperatures",
        )  # fmt: skip


def _packed(path: Path, error: Exception) -> InputError:
    return InputError(
        "this compression needs one more library", where=str(path), value=str(error)[:160],
        limit="TIFF without compression, or the library imagecodecs",
        remedy="pip install imagecodecs, or export without compression",
    )  # fmt: skip


@final
class _Listener(logging.Handler):
    """Keeps what is logged."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.heard: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.heard.append(record.getMessage())


@contextmanager
def _complaints(tifffile: Any) -> Iterator[list[str]]:
    """What the library only logs as errors, such as pages that a truncated file lacks."""
    listener = _Listener()
    logger = tifffile.logger()
    logger.addHandler(listener)
    try:
        yield listener.heard
    finally:
        logger.removeHandler(listener)
