"""Formats that their makers keep to themselves: what to export instead."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from thermo.errors import InputError

from ._folder import is_kind

_MAKERS: Final = {
    ".is3": ("Fluke", "SmartView"),
    ".irb": ("InfraTec", "IRBIS"),
    ".seq": ("FLIR", "FLIR Research Studio"),
    ".csq": ("FLIR", "FLIR Research Studio"),
    ".ptw": ("FLIR", "FLIR Research Studio"),
    ".ats": ("FLIR", "FLIR Research Studio"),
    ".ravi": ("Optris", "PIX Connect"),
}
"""Makers that do not publish their format, by suffix, and the program that exports it."""


def check_open(path: Path) -> None:
    """Raise `InputError` for a file, or a folder of files, of a format that is closed.

    It says what to export instead.
    """
    for suffix, (maker, program) in _MAKERS.items():
        if is_kind(path, (suffix,)):
            raise closed(path, f"a {suffix} file of {maker}", program)


def closed(path: Path, what: str, program: str, *, other: str = "") -> InputError:
    """The error for a format that is its maker's own, whose `program` exports it."""
    return InputError(
        "this format is its maker's own", where=str(path), value=what,
        limit="a format that is documented, or that a free library reads",
        remedy=f"{other}export from {program} (or the camera's own program): 16-bit or 32-bit "
        "TIFF, or one CSV a frame, with the times of the frames",
    )  # fmt: skip
