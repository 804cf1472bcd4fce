"""A CSV file as a table of numbers, with units in its header."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError

from ._npz import check_file

Units = Mapping[str, tuple[float, float]]
"""Factor and offset that turn each unit into the SI unit."""

PLAIN: Final[Units] = {}
TIME: Final[Units] = {"s": (1.0, 0.0), "ms": (1e-3, 0.0), "min": (60.0, 0.0), "h": (3600.0, 0.0)}
"""Units of time, what to multiply and to add for seconds [s]."""
LENGTH: Final[Units] = {
    "m": (1.0, 0.0), "cm": (1e-2, 0.0), "mm": (1e-3, 0.0), "inch": (0.0254, 0.0),
    "in": (0.0254, 0.0),
}  # fmt: skip
"""Units of length, what to multiply and to add for metres [m]."""
TEMPERATURE: Final[Units] = {
    "k": (1.0, 0.0), "c": (1.0, 273.15), "degc": (1.0, 273.15), "°c": (1.0, 273.15),
    "f": (5 / 9, 273.15 - 160 / 9), "degf": (5 / 9, 273.15 - 160 / 9),
}  # fmt: skip

_BRACKET = re.compile(r"^(?P<name>.*?)\s*[\[(](?P<unit>[^\])]*)[\])]$")
_MISSING = frozenset({"", "nan", "na", "n/a", "null", "none", "-"})
_EMPTY = " \t,;"


@final
@dataclass(frozen=True)
class Table:
    """The cells of a CSV file: its header, and the text of each row with its line number."""

    file: Path
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]
    decimal_comma: bool

    def bases(self, kinds: Mapping[str, Units]) -> dict[str, int]:
        """Return the column number of each name, without its unit where it is in `kinds`."""
        found: dict[str, int] = {}
        for column, text in enumerate(self.header):
            name = text
            for known, units in kinds.items():
                if split_unit(self.file, text, units)[0].casefold() == known:
                    name = known
            if name in found:
                raise InputError(
                    f"column `{name}` stands twice", where=str(self.file),
                    value=", ".join(self.header), limit="every column once",
                    remedy="remove or rename one of the two columns",
                )  # fmt: skip
            found[name] = column
        return found

    def numbers(
        self, column: int, units: Units, *, missing: bool = False, named: str | None = None
    ) -> Float[np.ndarray, " rows"]:
        """Return a column in SI units; `missing` turns empty cells into NaN, else refused.

        `named` says that the whole header text is a name, so that no unit is read from it.
        """
        text = self.header[column]
        unit = "" if named == text else split_unit(self.file, text, units)[1]
        factor, offset = units[unit] if unit else (1.0, 0.0)
        values = [self._number(row, column, missing) for row in range(len(self.rows))]
        return np.asarray(values, dtype=np.float64) * factor + offset

    def _number(self, row: int, column: int, missing: bool) -> float:
        cell = self.rows[row][column]
        if missing and cell.casefold() in _MISSING:
            return float("nan")
        try:
            return float(cell.replace(",", ".") if self.decimal_comma else cell)
        except ValueError:
            raise InputError(
                f"cell of column `{self.header[column]}` is not a number",
                where=f"{self.file}, line {self.lines[row]}", value=repr(cell),
                limit="a number" + (", or empty where it is missing" if missing else ""),
                remedy="correct the cell, or remove the row",
            ) from None  # fmt: skip


def read_table(path: Path) -> Table:
    """Read a CSV file with a header, separated by comma, semicolon or tab.

    Lines that are blank or start with `#` are skipped. Behind semicolons or tabs a comma is read
    as the decimal point.

    Raises `InputError` if the file is absent, not text, empty, without a header or ragged.
    """
    found, separator = csv_lines(path)
    kept = [(number, line) for number, line in found if line.strip(_EMPTY)]
    cells = [
        tuple(cell.strip() for cell in row)
        for row in _split(path, [line for _, line in kept], separator)
    ]
    if len(cells) < 2 or len(cells) != len(kept):
        raise InputError(
            "no rows of data", where=str(path), value=f"{len(kept)} lines that are not blank",
            limit="a header and at least one row, one line each",
            remedy="export the table again, with its header in the first line",
        )  # fmt: skip
    lines = tuple(number for number, _ in kept[1:])
    _check_header(path, cells[0])
    _check_width(path, cells, lines)
    return Table(path, cells[0], tuple(cells[1:]), lines, decimal_comma=separator != ",")


def csv_lines(path: Path) -> tuple[list[tuple[int, str]], str]:
    """Return the lines of a CSV file with their numbers, from 1, and what separates their cells.

    Lines of spaces and those that start with `#` are left out.

    Raises `InputError` if the file is absent or not text.
    """
    check_file(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (UnicodeDecodeError, OSError) as error:
        raise InputError(
            "not a text file", where=str(path), value=type(error).__name__,
            limit="CSV in UTF-8", remedy="export the table as CSV (UTF-8)",
        ) from error  # fmt: skip
    lines = [
        (number, line) for number, line in enumerate(text.splitlines(), start=1)
        if line.strip(" ") and not line.lstrip().startswith("#")
    ]  # fmt: skip
    first = next((line for _, line in lines if line.strip(_EMPTY)), "")
    return lines, next((mark for mark in ";\t" if mark in first), ",")


def _split(path: Path, lines: list[str], separator: str) -> list[list[str]]:
    try:
        return list(csv.reader(lines, delimiter=separator))
    except csv.Error as error:
        raise InputError(
            "not a CSV file", where=str(path), value=str(error), limit="rows of separated cells",
            remedy="export the table as CSV (UTF-8)",
        ) from error  # fmt: skip


def split_unit(file: Path, text: str, units: Units) -> tuple[str, str]:
    """Split a header such as `x_mm`, `x [mm]` or `x (mm)` into name and unit ("" for none)."""
    bracket = _BRACKET.match(text)
    if bracket:
        unit = bracket["unit"].strip().casefold()
        if unit in units:
            return bracket["name"].strip(), unit
        # A unit of another kind belongs to another column; one of no kind is a mistake.
        if not any(unit in kind for kind in (TIME, LENGTH, TEMPERATURE)):
            raise InputError(
                "unknown unit in the header", where=str(file), value=text,
                limit="; ".join(", ".join(kind) for kind in (TIME, LENGTH, TEMPERATURE)),
                remedy="convert the column to one of these units, or remove it where it is "
                "neither a time, a place nor a temperature",
            )  # fmt: skip
        return text, ""
    name, _, unit = text.rpartition("_")
    if name and unit.casefold() in units:
        return name, unit.casefold()
    return text, ""


def _check_header(path: Path, header: tuple[str, ...]) -> None:
    try:
        float(header[0].replace(",", "."))
    except ValueError:
        return
    raise InputError(
        "no header", where=str(path), value=", ".join(header[:6]),
        limit="column names in the first line",
        remedy="add a first line such as `time,x,y,z,temperature`, or `x,y,z` where points stand",
    )  # fmt: skip


def _check_width(path: Path, cells: list[tuple[str, ...]], lines: tuple[int, ...]) -> None:
    width = len(cells[0])
    for row, line in zip(cells[1:], lines, strict=True):
        if len(row) != width:
            raise InputError(
                "row of the wrong length", where=f"{path}, line {line}",
                value=f"{len(row)} cells", limit=f"{width} cells, as in the header",
                remedy="fill or remove the row; a missing temperature is an empty cell",
            )  # fmt: skip
