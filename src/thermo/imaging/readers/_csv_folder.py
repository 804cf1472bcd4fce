"""A folder of CSV files, one frame each."""

from __future__ import annotations

from pathlib import Path
from typing import Final, final

import numpy as np

from thermo.errors import InputError
from thermo.imaging._frames import Frames
from thermo.observe import csv_lines

from ._folder import is_kind, single_frames
from ._reader import AbstractReader
from ._stated import Stated

_SUFFIXES = (".csv",)
_MISSING: Final = frozenset({"", "nan", "na", "n/a", "-"})


@final
class CsvFolderReader(AbstractReader):
    """One CSV file a frame, a line a row, separated by comma, semicolon or tab.

    Behind semicolons and tabs a comma is the decimal point. Blank lines and those with `#` in
    front are skipped; empty cells are missing. `times.csv` (columns `file`, `time_s`) beside them
    gives the times, else `rate` or `times` are stated. Kelvin unless `unit` says otherwise.
    """

    def format(self) -> str:
        """The files that it reads."""
        return "a folder of CSV files, one frame each"

    def recognises(self, path: Path) -> bool:
        """By the suffix of the files in a folder."""
        return path.is_dir() and is_kind(path, _SUFFIXES)

    def read(self, path: Path, given: Stated) -> Frames:
        """The frames [K] or [1] and their times [s]; raises `InputError`."""
        return single_frames(path, _SUFFIXES, _read, given)


def _read(path: Path) -> np.ndarray:
    numbered, separator = csv_lines(path)
    if not numbered:
        raise InputError(
            "no rows of data", where=str(path), value=f"{path.stat().st_size} bytes",
            limit="a line of numbers a row of the frame", remedy="export the frame again",
        )  # fmt: skip
    lines = [line.replace(",", ".") if separator != "," else line for _, line in numbered]
    if all(line.rstrip(" ").endswith(separator) for line in lines):
        lines = [line.rstrip(" ")[:-1] for line in lines]  # exports often end lines with one
    try:
        return np.loadtxt(lines, delimiter=separator, dtype=np.float32, ndmin=2)
    except ValueError:
        rows = [
            [_number(path, number, cell) for cell in line.split(separator)]
            for (number, _), line in zip(numbered, lines, strict=True)
        ]
        return _rectangle(path, rows, [number for number, _ in numbered])


def _number(path: Path, line: int, cell: str) -> float:
    text = cell.strip()
    if text.casefold() in _MISSING:
        return float("nan")
    try:
        return float(text)
    except ValueError:
        raise InputError(
            "cell is not a number", where=f"{path}, line {line}", value=repr(text),
            limit="a number, or nothing where it is missing",
            remedy="export the values alone, or put # in front of lines of text",
        ) from None  # fmt: skip


def _rectangle(path: Path, rows: list[list[float]], lines: list[int]) -> np.ndarray:
    for row, line in zip(rows, lines, strict=True):
        if len(row) != len(rows[0]):
            raise InputError(
                "row of the wrong length", where=f"{path}, line {line}", value=f"{len(row)} cells",
                limit=f"{len(rows[0])} cells, as in the first row",
                remedy="the file may be truncated: export the frame again",
            )  # fmt: skip
    return np.array(rows, np.float32)
