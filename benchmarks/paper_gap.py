"""What makes the difference between the paper's method and ours: one ingredient changed at a time.

    python benchmarks/paper_gap.py SCENES [ROW ...] [--out FOLDER]

SCENES holds the paper's scenes; ROW is such as cube-heating, which is the default. Each fit leaves
its record in FOLDER, where an interrupted run goes on; benchmarks/results/paper_gap.csv has them
all.
"""

from __future__ import annotations

import argparse
import csv
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
    least_squares = replace(controls, optimiser=LevenbergMarquardt())
    return {
        "paper": PAPER,
        "second-order steps": replace(PAPER, stepping=BEST.stepping),
        "our mesh": replace(PAPER, meshing=BEST.meshing),
        "no smoothness": replace(PAPER, prior=replace(PAPER.prior, step=10.0)),
        "no decay": replace(PAPER, prior=replace(PAPER.prior, decay=0.0)),
        "control points": controls,
        "control points, least squares": least_squares,
        "control points, least squares, smoothness from the data": replace(
            least_squares, prior=Prior()
        ),
        "best": BEST,
    }


def main() -> None:
    """Fit all variants and write the table after each."""
    parser = argparse.ArgumentParser(description="the gap to the paper's method")
    parser.add_argument("scenes", type=Path)
    parser.add_argument("rows", nargs="*", default=["cube-heating"])
    parser.add_argument("--out", type=Path, default=Path("outputs/paper_gap"))
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    lines = []
    for row in asked.rows:
        for method, preset in variants().items():
            name = method.replace(", ", "-").replace(" ", "_")
            case = Case(ROWS[row], name, preset, asked.scenes, False, False, "smoothness")
            record = study_case(case, asked.out)
            numbers = [record[key] for key in ("error", "ratio", "width", "rmse", "seconds")]
            lines.append([row, method, *(f"{number:.4g}" for number in numbers)])
            print(*lines[-1], flush=True)
            with (RESULTS / "paper_gap.csv").open("w", newline="") as stream:
                csv.writer(stream, lineterminator="\n").writerows([COLUMNS, *lines])


if __name__ == "__main__":
    main()
