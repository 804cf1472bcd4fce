"""Radiometric JPEG, one or a folder of them: whose format it is, and when it was taken."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np
from jaxtyping import Shaped

from thermo.imaging._frames import Frames

from ._damaged import damaged
from ._folder import first_bytes, frame_files, is_kind, single_frames
from ._stated import Stated
from ._taken import Taken, dates_of, taken

SUFFIXES: Final = (".jpg", ".jpeg", ".rjpg")
_BEGINNING = b"\xff\xd8\xff"

_SEGMENT: Final = 1 << 16
"""The most that a segment of a JPEG holds [bytes]; the first one says who made the camera."""

_SEGMENTS: Final = 16
"""Segments within which data of FLIR begin: the second one, or behind those of a drone."""


def is_jpeg(path: Path) -> bool:
    """Whether a file, or at least one of a folder, is a JPEG, by suffix or by the first bytes."""
    return is_kind(path, SUFFIXES) or first_bytes(path, len(_BEGINNING)) == _BEGINNING


def is_of_dji(path: Path) -> bool:
    """Whether a JPEG, or the first of a folder, may be in DJI's own format.

    DJI's earlier cameras held a FLIR core and wrote FLIR's format, which is not.
    """
    file = next(iter(frame_files(path, SUFFIXES)), path) if path.is_dir() else path
    begin = first_bytes(file, _SEGMENTS * _SEGMENT)
    maker = begin[:_SEGMENT]
    return begin.startswith(_BEGINNING) and b"DJI" in maker and b"FLIR\x00" not in begin


def jpeg_frames(
    path: Path,
    read: Callable[[Path, bytes], Shaped[np.ndarray, "..."]],
    given: Stated,
    *,
    unit: str,
) -> Frames:
    """Frames in `unit` of a JPEG or a folder of them, `read` from a file's content; times [s].

    Times are those that the pictures tell, unless `times.csv` is beside them. Raises `InputError`.
    """
    when: list[Taken] = []

    def one(file: Path) -> np.ndarray:
        content = file.read_bytes()
        if not content.startswith(_BEGINNING):
            raise damaged(file, "JPEG file", "another beginning")
        when.append(taken(content))
        return read(file, content)

    return single_frames(path, SUFFIXES, one, given, unit=unit, dates=lambda: dates_of(when))
