"""Plain tables for the terminal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def _cell(value: object) -> str:
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return f"{value:.4g}"
    return "-" if value is None else str(value)


def table(rows: Sequence[Sequence[object]], header: Sequence[str]) -> str:
    """A table as text, without a newline at the end.

    Arguments:
    - `rows`: the cells of each row. Floats show four digits, truth values yes or no, `None` a
      dash. Columns that hold only numbers are aligned to the right.
    - `header`: the names of the columns, each with its unit in brackets.

    Raises `ValueError` where a row does not have as many cells as the header.
    """
    for row in rows:
        if len(row) != len(header):
            raise ValueError(f"a row of {len(row)} cells under a header of {len(header)}")
    columns = [[row[i] for row in rows] for i in range(len(header))]
    lines = [list(header), [], *[[_cell(value) for value in row] for row in rows]]
    aligned = []
    for i, column in enumerate(columns):
        width = max(len(line[i]) for line in lines if line)
        number = (int, float, np.number, type(None))
        right = bool(column) and all(
            isinstance(v, number) and not isinstance(v, bool) for v in column
        )
        aligned.append([
            (line[i].rjust(width) if right else line[i].ljust(width)) if line else "-" * width
            for line in lines
        ])  # fmt: skip
    return "\n".join("  ".join(cells).rstrip() for cells in zip(*aligned, strict=True))
