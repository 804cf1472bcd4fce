"""The tables of a study, beside the paper's numbers."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from thermo.report import table, write_text
from thermo.study._ensemble_groups import Record, groups
from thermo.study._paper import BOTH, HELD_OUT, JOINT, REPEATED, ROWS

Lines = list[list[Any]]

LABEL = ("scene", "preset", "noise")

RECOVERY = (*LABEL, "expected", "informed", "error", "ratio", "width",
            "paper error", "paper ratio", "paper width", "rmse [K]", "seconds")  # fmt: skip

TRANSFER = (*LABEL, "test",
            "spatial mae [K]", "spatial rmse [K]", "spatial max [K]",
            "median mae [K]", "median rmse [K]", "median max [K]",
            "paper spatial mae", "paper median mae")  # fmt: skip

PROCESSES = (*LABEL, "expected", "error", "ratio", "width",
             "warming mae [K]", "heating mae [K]")  # fmt: skip

SMOOTHNESS = (*LABEL, "step", "weight", "error", "ratio", "width", "rmse [K]")

ENSEMBLES = (*LABEL, "fits", "ratio", "deviation", "width", "share of start", "final mae [K]",
             "paper ratio", "paper width", "paper final mae")  # fmt: skip


def _label(record: Record) -> list[Any]:
    return [record["row"], record["preset"], record["noise"]]


def _of(records: Sequence[Record], *parts: str) -> list[Record]:
    return [record for record in records if record["part"] in parts]


def recovery(records: Sequence[Record]) -> Lines:
    """Table 1: errors, ratios and widths [1] of recovered fields, with the paper's."""
    lines = []
    for record in _of(records, "tables"):
        paper = ROWS[record["row"]]
        ours = [record.get(name) for name in ("expected", "informed", "error", "ratio", "width")]
        theirs = [paper.error, paper.ratio, paper.width]
        lines.append([*_label(record), *ours, *theirs, record["rmse"], record["seconds"]])
    return lines


def transfer(records: Sequence[Record]) -> Lines:
    """Table 2: errors [K] of predictions by the field and by its median, with the paper's."""
    lines = []
    for record in _of(records, "tables"):
        for test, scores in record.get("held_out", {}).items():
            paper = getattr(ROWS[record["row"]], test) or (None, None)
            both = [
                scores[kind][name]
                for kind in ("spatial", "median")
                for name in ("mae", "rmse", "max")
            ]
            lines.append([*_label(record), test, *both, *paper])
    return lines


def processes(records: Sequence[Record]) -> Lines:
    """Cooling, heating and both at once, of objects that were fitted in all three ways."""
    lines = []
    for joint in _of(records, "processes"):
        like = [joint[key] for key in ("object", "preset", "noise")]
        for record in sorted(_of(records, "tables", "processes"), key=_process):
            if [record[key] for key in ("object", "preset", "noise")] == like:
                ours = [record.get(name) for name in ("expected", "error", "ratio", "width")]
                made = record.get("held_out", {})
                tests = [made[test]["spatial"]["mae"] if test in made else None
                         for test in HELD_OUT]  # fmt: skip
                lines.append([*_label(record), *ours, *tests])
    return lines


def _process(record: Record) -> int:
    return (*BOTH, JOINT).index(record["process"])


def smoothness(records: Sequence[Record]) -> Lines:
    """Width against the weight of the prior, 1/step^2 [1]."""
    lines = []
    for record in _of(records, "smoothness"):
        ours = [record[name] for name in ("error", "ratio", "width", "rmse")]
        lines.append([*_label(record), record["step"], record["step"] ** -2, *ours])
    return lines


def ensembles(records: Sequence[Record]) -> Lines:
    """Figure 3: medians over repeated fits, their deviation, the part that the start makes."""
    lines = []
    for group in groups(records):
        found = group.found
        share = None if found.split is None else found.split.share()
        ours = [found.members, found.median, found.deviation, found.width, share]
        paper = REPEATED.get(group.row, (None, None, None))
        label = [group.row, group.preset, group.noise]
        lines.append([*label, *ours, found.final_error, *paper])
    return lines


TABLES: Mapping[str, tuple[Sequence[str], Callable[[Sequence[Record]], Lines]]] = {
    "recovery": (RECOVERY, recovery),
    "transfer": (TRANSFER, transfer),
    "processes": (PROCESSES, processes),
    "smoothness": (SMOOTHNESS, smoothness),
    "ensembles": (ENSEMBLES, ensembles),
}
"""Tables by the name of their file."""


def write_tables(folder: Path, records: Sequence[Record]) -> str:
    """Write all tables as CSV and as `tables.md`, and return them as text.

    Arguments: `records`: of the cases [SI].
    """
    text, pages = [], []
    for name, (header, made) in TABLES.items():
        lines = made(records)
        if lines:
            write_text(folder / f"{name}.csv", _csv(header, lines))
            text.append(table(lines, header))
            pages.append(_markdown(header, lines))
    write_text(folder / "tables.md", "\n".join(pages))
    return "\n\n".join(text)


def _word(cell: Any) -> str:
    if cell is None:
        return ""
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    return f"{cell:.3g}" if isinstance(cell, float) else str(cell)


def _markdown(header: Sequence[str], lines: Sequence[Sequence[Any]]) -> str:
    rows = [header, ["---"] * len(header), *[[_word(cell) for cell in line] for line in lines]]
    return "".join("| " + " | ".join(row) + " |\n" for row in rows)


def _csv(header: Sequence[str], lines: Sequence[Sequence[Any]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(
        [f"{round(cell, 12):.4g}" if isinstance(cell, float) else cell for cell in line]
        for line in lines
    )
    return stream.getvalue()
