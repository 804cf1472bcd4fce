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

_HEAD: Final = 65536


def check_open(path: Path) -> None:
    """Raise `InputError` for a file, or a folder of files, of a format that is closed.

    It says what to export instead.
    """
    for suffix, (maker, program) in _MAKERS.items():
        if is_kind(path, (suffix,)):
            raise _closed(path, f"a {suffix} file of {maker}", program)


def check_no_dji(path: Path, content: bytes) -> None:
    """Raise `InputError` for a radiometric JPEG of DJI's own: only its Thermal SDK can read it.

    DJI's earlier cameras held a FLIR core and wrote FLIR's format, which passes.
    """
    if b"DJI" in content[:_HEAD] and b"FLIR\x00" not in content:
        raise _closed(path, "a radiometric JPEG of DJI", "DJI Thermal Analysis Tool")


def _closed(path: Path, what: str, program: str) -> InputError:
    return InputError(
        "this format is its maker's own", where=str(path), value=what,
        limit="a format that is documented, or that a free library reads",
        remedy=f"export from {program} (or the camera's own program): 16-bit or 32-bit TIFF, or "
        "one CSV a frame, with the times of the frames",
    )  # fmt: skip
