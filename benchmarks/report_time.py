"""How long `thermo identify` takes after a fit, beside that fit.

    python benchmarks/report_time.py

Two reports of the bracket's three runs: of six unknowns after a fit of four of them, and of a field
on 300 points after the fit of `make demo`. Seconds of whole commands, Python's start among them,
with nothing compiled or meshed before the fits; the reports use what the fits have kept. Leaves
benchmarks/results/report_time.csv and prints it.
"""

from __future__ import annotations

import csv
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
TABLE = HERE / "results" / "report_time.csv"
OUT = Path("outputs/report_time")
DATA = f"data={HERE.parent / 'examples' / 'bracket'}"
BODY = "conductivity,volumetric_heat_capacity,convection,emissivity"
FITS = {
    "6 unknowns": [f"unknown=[{BODY}]", "field=uniform", "initial.conductivity=1.5"],
    "field on 300 points": ["unknown=[conductivity]", "field=two_materials", "optimiser=lm"],
}
REPORTS = {
    "6 unknowns": [f"unknown=[{BODY},heater_power,camera_emissivity]", "field=uniform"],
    "field on 300 points": ["controls=300"],
}


def main() -> None:
    """A fit and its report, twice."""
    rows = []
    for number, (name, fit) in enumerate(FITS.items()):
        out = OUT / str(number)
        shutil.rmtree(out, ignore_errors=True)
        estimate = out / "fit"
        seconds = [
            timed(["invert", DATA, *fit, f"out={estimate}"], out),
            timed(
                ["identify", DATA, f"estimate={estimate}", *REPORTS[name], f"out={out / 'report'}"],
                out,
            ),
        ]
        rows.append([name, *(f"{one:.0f}" for one in seconds)])
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([["case", "fit [s]", "report [s]"], *rows])
    print(TABLE.read_text("utf-8"))


def timed(words: list[str], out: Path) -> float:
    """Seconds of one command, with caches of its own."""
    begun = time.perf_counter()
    settings = {"XDG_CACHE_HOME": str((out / "cache").resolve())}
    subprocess.run([sys.executable, "-m", "thermo", *words], check=True, env=os.environ | settings)
    return time.perf_counter() - begun


if __name__ == "__main__":
    main()
