"""What no data can tell apart: does `thermo identify` say so, and in which words.

    python benchmarks/symmetries.py DATA/scenes

Three cases before a fit, at the values that the scenes state. A copper sphere that cools is as warm
inside as outside: with a camera's noise (0.05 K, a fixed pattern of 0.03 K) its diffusivity must be
`weak` or `not_identified` while h / (rho c) is known, and where conductivity, capacity, convection
and emissivity are free, factors that they have in common have to be named. A plastic cube under a
lamp whose power is free tells ratios only. That a body which cools alone tells ratios, and that a
lamp's power and a camera's gain hide each other, is asked of a solver with tight tolerances in
tests/identify/test_spectrum.py. Leaves benchmarks/results/symmetries.csv and prints it.
"""

from __future__ import annotations

import argparse
import csv
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

TABLE = Path(__file__).parent / "results" / "symmetries.csv"
HEADER = ["case", "unknown", "relative deviation", "informed by data", "verdict", "in words"]
BODY = ["conductivity", "volumetric_heat_capacity", "convection", "emissivity"]
NOISE, PATTERN, QUIET = 0.05, 0.03, 25  # [K], [K], frames before the run
SEED = 0


def main() -> None:
    """Run the three, write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", type=Path)
    parser.add_argument("--out", type=Path, default=Path("outputs/symmetries"))
    asked = parser.parse_args()
    sphere = noisy(asked.scenes / "sphere", "cooling", asked.out / "sphere")
    cases = {
        "sphere, cooling": (sphere, "cooling", ["diffusivity", "scaled_convection"]),
        "sphere, cooling, all of the body": (sphere, "cooling", BODY),
        "cube, heating": (asked.scenes / "cube", "heating", [*BODY, "heater_power"]),
    }
    rows = []
    for number, (case, (data, run, unknown)) in enumerate(cases.items()):
        out = asked.out / str(number)
        words = [f"data={data}", f"runs=[{run}]", f"unknown=[{','.join(unknown)}]", f"out={out}"]
        subprocess.run([sys.executable, "-m", "thermo", "identify", *words], check=True)
        rows += told(case, out)
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([HEADER, *rows])
    print(TABLE.read_text("utf-8"))


def noisy(scene: Path, run: str, out: Path) -> Path:
    """The scene with one of its runs, as a camera would record it."""
    out.mkdir(parents=True, exist_ok=True)
    stated = json.loads((scene / "scene.json").read_text("utf-8"))
    stated["runs"] = {run: stated["runs"][run]}
    stored = np.load(scene / f"{run}.npz")
    draw = np.random.default_rng(SEED)
    exact = stored["temperature"]
    pattern = PATTERN * draw.standard_normal(exact.shape[1])
    before = np.full((QUIET, exact.shape[1]), stated["runs"][run]["initial_temperature"])
    read, quiet = (
        clean + pattern + NOISE * draw.standard_normal(clean.shape) for clean in (exact, before)
    )
    np.savez(
        out / f"{run}.npz",
        points=stored["points"],
        time=stored["time"],
        temperature=read,
        quiet=quiet,
    )
    shutil.copy(scene / stated["surface"], out / stated["surface"])
    (out / "scene.json").write_text(json.dumps(stated), "utf-8")
    return out


def told(case: str, out: Path) -> list[list[str]]:
    """A row a value, and one for each thing that is said of several."""
    found = json.loads((out / "identifiability.json").read_text("utf-8"))
    values, sentences = found["parameters"], found["sentences"]
    rows = [
        [
            case, name, f"{one['relative']:.2g}", f"{one['informed_by_data']:.3f}",
            one["verdict"], said,
        ]
        for (name, one), said in zip(values.items(), sentences, strict=False)
    ]  # fmt: skip
    return rows + [[case, "", "", "", "", said] for said in sentences[len(values) :]]


if __name__ == "__main__":
    main()
