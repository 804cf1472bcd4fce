"""Where simulation and readings differ, without and with what `thermo discover` found.

    python examples/gap_map.py FOLDER [--figure FILE]

FOLDER is what `thermo discover ... out=FOLDER` left. Each run has a row: the root mean square
difference of each sample over the frames, seen along the axis in which the samples reach the least,
on one scale for both. Where nothing was found, the right side stays empty. A circle stands where an
effect with a place was found, as wide as its size.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

AXES = "xyz"
MILLI = 1e3


def draw(verdict: dict[str, Any], path: Path) -> None:
    """The maps of all runs of a record [K], as PNG."""
    runs = verdict["residuals"]
    figure = Figure(figsize=(8.4, 2.9 * len(runs)), layout="constrained")
    axes = figure.subplots(len(runs), 2, squeeze=False, sharex=True, sharey=True)
    for row, (name, run) in zip(axes, runs.items(), strict=True):
        points = MILLI * np.asarray(run["points"])
        flat = int(np.argmin(np.ptp(points, axis=0)))
        seen = [axis for axis in range(3) if axis != flat]
        told = {when: values for when, values in run["by_sample"].items() if values is not None}
        most = max(max(values) for values in told.values())
        for panel, when in zip(row, ("before", "after"), strict=True):
            if when not in told:
                panel.axis("off")
                continue
            values = told[when]
            dots = panel.scatter(*points[:, seen].T, c=values, s=14, vmin=0, vmax=most)
            _places(panel, verdict["rounds"] if verdict["effects"] else [], seen)
            panel.set_aspect("equal")
            panel.set_title(f"{name}, {when}", fontsize=9)
            panel.set_xlabel(f"{AXES[seen[0]]} [mm]", fontsize=8)
        row[0].set_ylabel(f"{AXES[seen[1]]} [mm]", fontsize=8)
        figure.colorbar(dots, ax=row, label="difference [K]")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


def _places(panel: Axes, rounds: list[dict[str, Any]], seen: list[int]) -> None:
    for found in rounds:
        place = found["location"]
        if place is None:
            continue
        middle = [MILLI * place["centre"][axis] for axis in seen]
        size = MILLI * float(np.max(place["size"]))
        panel.add_patch(Circle((middle[0], middle[1]), size, fill=False, color="tab:red"))


def main() -> None:
    """Draw what a folder holds."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="what thermo discover left")
    parser.add_argument("--figure", type=Path, help="the picture; gap_map.png in that folder")
    asked = parser.parse_args()
    record = asked.folder / "verdict.json"
    if not record.is_file():
        sys.exit(f"gap_map: no {record}: give the folder that `thermo discover out=...` left")
    figure = asked.figure or asked.folder / "gap_map.png"
    draw(json.loads(record.read_text("utf-8")), figure)
    print(figure)


if __name__ == "__main__":
    main()
