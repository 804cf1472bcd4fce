"""When a picture was taken, by what it says itself."""

from __future__ import annotations

import datetime
import io
import re
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from jaxtyping import Float

_DETAILS: Final = 0x8769
_ORIGINAL, _PART_ORIGINAL = 0x9003, 0x9291
_CHANGED, _PART = 0x0132, 0x9290
_EXPOSED = re.compile(rb'drone-dji:UTCAtExposure\s*(?:=\s*["\']|>)\s*([0-9][0-9T:.+Z-]{9,39})')


class Taken(NamedTuple):
    """When a picture was taken by each clock that tells it [s]; only differences mean something."""

    exposed: float | None
    """By satellite, to parts of a second, which DJI's drones write into the picture's XMP."""
    dated: float | None
    """By the camera's clock in its Exif data, whose place is read as if it were at Greenwich."""


def taken(content: bytes) -> Taken:
    """The times that a JPEG tells [s].

    Source: Exif 2.32, tags DateTimeOriginal and DateTime with their parts of a second; DJI Matrice
    4 Series User Manual (2025), p. 91, UTCAtExposure.
    """
    return Taken(_exposed(content), _dated(content))


def dates_of(when: Sequence[Taken]) -> Float[np.ndarray, " frames"] | None:
    """Times of pictures [s] by the first clock that all of them tell; None without one.

    Whole seconds that repeat are too coarse to be times of frames.
    """
    for clock in zip(*when, strict=True):
        if None in clock:
            continue
        dates = np.array(clock, float)
        whole = bool((dates == np.round(dates)).all())
        if not (whole and (np.diff(dates) == 0).any()):
            return dates
    return None


def _exposed(content: bytes) -> float | None:
    found = _EXPOSED.search(content)
    try:
        moment = datetime.datetime.fromisoformat(found[1].decode()) if found else None
    except ValueError:
        return None
    return None if moment is None else _since(moment)


def _dated(content: bytes) -> float | None:
    from PIL import Image

    try:
        with Image.open(io.BytesIO(content)) as picture:
            exif = picture.getexif()
            details = exif.get_ifd(_DETAILS)
    except Exception:  # a damaged picture: what reads it next tells so
        return None
    for date, part in (
        (details.get(_ORIGINAL), details.get(_PART_ORIGINAL)),
        (exif.get(_CHANGED), details.get(_PART)),
    ):
        seconds = _seconds(date)
        if seconds is not None:
            return seconds + _fraction(part)
    return None


def _since(moment: datetime.datetime) -> float:
    return (moment if moment.tzinfo else moment.replace(tzinfo=datetime.UTC)).timestamp()


def _seconds(date: object) -> float | None:
    try:
        moment = datetime.datetime.strptime(str(date).strip("\x00 "), "%Y:%m:%d %H:%M:%S")
    except ValueError:
        return None
    return _since(moment)


def _fraction(part: object) -> float:
    digits = str(part).strip("\x00 ")
    return float(f"0.{digits}") if digits.isascii() and digits.isdigit() else 0.0
