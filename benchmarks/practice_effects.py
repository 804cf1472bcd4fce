"""Recordings with hidden effects: what `thermo discover` says of each, against what was hidden.

    python benchmarks/practice_effects.py EFFECTS [CASE ...] [--blind] [--out FOLDER]

EFFECTS holds one scene folder a case and `truth/CASE.json`, which is read after the verdict only.
Each case is run as a user would, with default settings; a case whose `verdict.json` is there
already is not run again. Leaves a table in benchmarks/results/practice_effects.csv where all cases
were asked for, and prints it. With `--blind` the recordings lose their quiet frames first, so that
their noise has to be learnt, and the table is practice_effects_blind.csv.
"""

from __future__ import annotations

import argparse
import csv
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

RESULTS = Path(__file__).parent / "results"
HEADER = [
    "case", "hidden", "verdict", "named", "strength", "low", "high", "true strength", "unit",
    "gap closed", "held out before [K]", "held out after [K]", "noise [K]", "right", "seconds",
]  # fmt: skip


def main() -> None:
    """Run what is missing, score all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("effects", type=Path)
    parser.add_argument("cases", nargs="*")
    parser.add_argument("--blind", action="store_true", help="leave out quiet frames")
    parser.add_argument("--out", type=Path, default=Path("outputs/practice"))
    asked = parser.parse_args()
    folders = sorted(one.parent.name for one in asked.effects.glob("*/scene.json"))
    folders.sort(key=lambda name: (len(name), name))
    rows = []
    for name in asked.cases or folders:
        out = asked.out / name
        if not (out / "verdict.json").exists():
            data = asked.effects / name
            if asked.blind:
                data = without_quiet_frames(data, asked.out / f"{name}-scene")
            words = ["discover", f"data={data}", f"out={out}"]
            subprocess.run([sys.executable, "-m", "thermo", *words], check=True)
        found = json.loads((out / "verdict.json").read_text("utf-8"))
        truth = json.loads((asked.effects / "truth" / f"{name}.json").read_text("utf-8"))
        rows.append(scored(name, found, truth))
        print(", ".join(str(one) for one in rows[-1]), flush=True)
    if not asked.cases:
        table = RESULTS / ("practice_effects_blind.csv" if asked.blind else "practice_effects.csv")
        with table.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([HEADER, *rows])


def without_quiet_frames(scene: Path, copy: Path) -> Path:
    """A copy of a scene whose recordings have no frames from before their runs."""
    shutil.copytree(scene, copy, dirs_exist_ok=True)
    for file in copy.glob("*.npz"):
        with np.load(file) as recording:
            kept = {name: recording[name] for name in recording.files if name != "quiet"}
        np.savez_compressed(file, **kept)
    return copy


def scored(name: str, found: dict[str, Any], truth: dict[str, Any]) -> list[Any]:
    """A row of the table."""
    hidden = truth["effect"]
    first = found["rounds"][0] if found["rounds"] else None
    within = [] if first is None else first["set"]
    right = found["verdict"] == "no_gap" if hidden == "none" else hidden in within
    proof = next(iter(found["held_out"].values()))
    numbers = [None] * 3 if first is None else [first["strength"], *first["interval95"]]
    return [
        name, hidden, found["verdict"], " ".join(found["effects"]),
        *(None if one is None else f"{one:.4g}" for one in numbers), truth.get("strength"),
        None if first is None else first["unit"],
        None if first is None else f"{first['gap_closed']:.4f}",
        f"{proof['rms_before']:.4f}", f"{proof['rms_after']:.4f}", f"{proof['noise']:.4f}",
        "yes" if right and len(found["effects"]) <= 1 else "no", f"{found['seconds']:.0f}",
    ]  # fmt: skip


if __name__ == "__main__":
    main()
