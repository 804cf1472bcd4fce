"""The tables of a study, beside the paper's numbers."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from thermo.report import table, write_text
from thermo.study._paper import ROWS

Record = Mapping[str, Any]

RECOVERY = ("scene", "preset", "noise", "expected", "informed", "error", "ratio", "width",
            "paper error", "paper ratio", "paper width", "rmse [K]", "seconds")  # fmt: skip

TRANSFER = ("scene", "preset", "noise", "test",
            "spatial mae [K]", "spatial rmse [K]", "spatial max [K]",
            "median mae [K]", "median rmse [K]", "median max [K]",
            "paper spatial mae", "paper median mae")  # fmt: skip


def recovery(records: Sequence[Record]) -> list[list[Any]]:
    """Table 1: errors, ratios and widths [1] of recovered fields, with the paper's."""
    rows = []
    for record in records:
        paper = ROWS[record["row"]]
        ours = [record[name] for name in ("expected", "informed", "error", "ratio", "width")]
        theirs = [paper.error, paper.ratio, paper.width]
        label = [record["row"], record["preset"], record["noise"]]
        rows.append([*label, *ours, *theirs, record["rmse"], record["seconds"]])
    return rows


def transfer(records: Sequence[Record]) -> list[list[Any]]:
    """Table 2: errors [K] of predictions by the field and by its median, with the paper's."""
    rows = []
    for record in records:
        for test, scores in record.get("held_out", {}).items():
            paper = getattr(ROWS[record["row"]], test) or (None, None)
            both = [
                scores[kind][name]
                for kind in ("spatial", "median")
                for name in ("mae", "rmse", "max")
            ]
            rows.append([record["row"], record["preset"], record["noise"], test, *both, *paper])
    return rows


def write_tables(folder: Path, records: Sequence[Record]) -> str:
    """Write both tables as CSV and as `tables.md`, and return them as text.

    Arguments: `records`: of the cases [SI].
    """
    text, pages = [], []
    for name, header, rows in (
        ("recovery", RECOVERY, recovery(records)),
        ("transfer", TRANSFER, transfer(records)),
    ):
        if rows:
            write_text(folder / f"{name}.csv", _csv(header, rows))
            text.append(table(rows, header))
            pages.append(_markdown(header, rows))
    write_text(folder / "tables.md", "\n".join(pages))
    return "\n\n".join(text)


def _word(cell: Any) -> str:
    if cell is None:
        return ""
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    return f"{cell:.3g}" if isinstance(cell, float) else str(cell)


def _markdown(header: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    lines = [header, ["---"] * len(header), *[[_word(cell) for cell in row] for row in rows]]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def _csv(header: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(
        [f"{round(cell, 12):.4g}" if isinstance(cell, float) else cell for cell in row]
        for row in rows
    )
    return stream.getvalue()
