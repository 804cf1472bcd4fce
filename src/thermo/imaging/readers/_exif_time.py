"""When a picture was taken, by its Exif data."""

from __future__ import annotations

import datetime
import io
from typing import Final

_DETAILS: Final = 0x8769
_ORIGINAL, _PART_ORIGINAL = 0x9003, 0x9291
_CHANGED, _PART = 0x0132, 0x9290


def exif_time(content: bytes) -> float | None:
    """Seconds of the date in a JPEG [s], parts of a second where it tells them; None without one.

    The clock of the camera's place is read as if it were universal time: only differences of these
    times mean something.
    """
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


def _seconds(date: object) -> float | None:
    try:
        moment = datetime.datetime.strptime(str(date).strip("\x00 "), "%Y:%m:%d %H:%M:%S")
    except ValueError:
        return None
    return moment.replace(tzinfo=datetime.UTC).timestamp()


def _fraction(part: object) -> float:
    digits = str(part).strip("\x00 ")
    return float(f"0.{digits}") if digits.isascii() and digits.isdigit() else 0.0
