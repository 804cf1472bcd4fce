"""What makes the difference between the paper's method and ours: one ingredient changed at a time.

    python benchmarks/paper_gap.py SCENES [ROW ...] [--methods NAME ...] [--out FOLDER]

SCENES holds the paper's scenes; ROW is such as cube-heating, which is the default; all methods are
tried unless some are named. Each fit leaves its record in FOLDER, where an interrupted run goes on;
benchmarks/results/paper_gap.csv has all that are there.
"""

from __future__ import annotations

import argparse
import csv
import json
from dataclasses import replace
from pathlib import Path

from thermo.inverse import LevenbergMarquardt, OnControlPoints, Prior
from thermo.study import PRESETS, ROWS, Case, Preset, study_case

RESULTS = Path(__file__).resolve().parent / "results"
COLUMNS = ("scene", "method", "error", "ratio", "width", "rmse [K]", "seconds")

PAPER, BEST = PRESETS["paper"], PRESETS["best"]


def variants() -> dict[str, Preset]:
    """The paper's preset, with one thing as ours, or more or less of one thing, at a time."""
    controls = replace(PAPER, choice=OnControlPoints(count=60))
    bare = replace(PAPER.meshing, corrected=False)
    least_squares = replace(controls, optimiser=LevenbergMarquardt(), meshing=bare)
    return {
        "paper": PAPER,
        "second-order steps": replace(PAPER, stepping=BEST.stepping),
        "our mesh": replace(PAPER, meshing=BEST.meshing),
        "no smoothness": replace(PAPER, prior=replace(PAPER.prior, step=10.0)),
        "no decay": replace(PAPER, prior=replace(PAPER.prior, decay=0.0)),
        "control points": controls,
        "control points, least squares": least_squares,
        "control points, least squares, smoothness from the data": replace(
            least_squares, prior=Prior(), meshing=PAPER.meshing
        ),
        "best, not corrected": replace(BEST, meshing=replace(BEST.meshing, corrected=False)),
        "best": BEST,
    }


def case_of(row: str, method: str, scenes: Path) -> Case:
    """The fit of a row by a method."""
    name = method.replace(", ", "-").replace(" ", "_")
    return Case(ROWS[row], name, variants()[method], scenes, False, False, "smoothness")


def write(folder: Path, scenes: Path) -> None:
    """The table of all records in a folder."""
    lines = []
    for row in ROWS:
        for method in variants():
            path = folder / f"{case_of(row, method, scenes).name()}.json"
            if path.exists():
                record = json.loads(path.read_text("utf-8"))
                numbers = [record[key] for key in ("error", "ratio", "width", "rmse", "seconds")]
                lines.append([row, method, *(f"{number:.4g}" for number in numbers)])
    with (RESULTS / "paper_gap.csv").open("w", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows([COLUMNS, *lines])


def main() -> None:
    """Fit the variants and write the table after each."""
    parser = argparse.ArgumentParser(description="the gap to the paper's method")
    parser.add_argument("scenes", type=Path)
    parser.add_argument("rows", nargs="*", default=["cube-heating"])
    parser.add_argument("--methods", nargs="+", choices=tuple(variants()), default=variants())
    parser.add_argument("--out", type=Path, default=Path("outputs/paper_gap"))
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    for row in asked.rows:
        for method in asked.methods:
            record = study_case(case_of(row, method, asked.scenes), asked.out)
            print(row, method, f"error {record['error']:.4g}", flush=True)
            write(asked.out, asked.scenes)


if __name__ == "__main__":
    main()
