"""The same fit and the same verdicts on the processor and on a GPU: do they agree, how long each.

    python benchmarks/on_gpu.py EFFECTS [CASE ...] [--out FOLDER]

Needs a JAX that sees a GPU (`pip install "jax[cuda13]"`). Fits the bracket as `make demo` does, and
runs `thermo discover` on the cases of EFFECTS, each once with JAX_PLATFORMS=cpu and once with
cuda. All runs of one kind go side by side, the processor's first: the meshes that it makes are kept
under FOLDER and used by both, so that what differs is the arithmetic. Seconds are those that each
run tells of itself, compiling included, and of the processor meshing too where its meshes were not
kept before. Leaves benchmarks/results/on_gpu.csv and prints it.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
TABLE = HERE / "results" / "on_gpu.csv"
BRACKET = HERE.parent / "examples" / "bracket"
HEADER = ["case", "processor", "GPU", "differ by", "processor [s]", "GPU [s]"]
FIT = ["unknown=[conductivity]", "field=two_materials", "optimiser=lm"]


def main() -> None:
    """Run both, compare, write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("effects", type=Path)
    parser.add_argument("cases", nargs="*")
    parser.add_argument("--out", type=Path, default=Path("outputs/on_gpu"))
    asked = parser.parse_args()
    jobs = {"bracket": ["invert", f"data={BRACKET}", *FIT]}
    jobs |= {case: ["discover", f"data={asked.effects / case}"] for case in asked.cases}
    with ThreadPoolExecutor(len(jobs)) as pool:
        for platform in ("cpu", "cuda"):
            runs = [pool.submit(run, jobs[case], asked.out, case, platform) for case in jobs]
            for each in runs:
                each.result()
    rows = [["bracket", *of_fits(*(asked.out / one / "bracket" for one in ("cpu", "cuda")))]]
    rows += [
        [case, *of_verdicts(*(asked.out / one / case for one in ("cpu", "cuda")))]
        for case in asked.cases
    ]
    TABLE.parent.mkdir(exist_ok=True)
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([HEADER, *rows])
    print(TABLE.read_text("utf-8"))


def run(words: list[str], out: Path, case: str, platform: str) -> None:
    """One command, in a Python of its own, with nothing compiled before."""
    there = out / platform / case
    there.mkdir(parents=True, exist_ok=True)
    settings = {
        "JAX_PLATFORMS": platform,
        "JAX_ENABLE_COMPILATION_CACHE": "false",
        "XLA_PYTHON_CLIENT_PREALLOCATE": "false",  # several share one GPU
        "XDG_CACHE_HOME": str((out / "meshes").resolve()),
    }
    command = [sys.executable, "-m", "thermo", *words, f"out={there}"]
    with (there / "console.txt").open("w", encoding="utf-8") as console:
        subprocess.run(
            command, check=True, env=os.environ | settings, stdout=console, stderr=console
        )


def of_fits(processor: Path, gpu: Path) -> list[Any]:
    """Median conductivity of both, the largest relative difference at a point, seconds."""
    fields = []
    for folder in (processor, gpu):
        with (folder / "field.npz").open("rb") as stream, np.load(stream) as stored:
            fields.append(np.asarray(stored["conductivity"]))
    return [
        *(f"median {np.median(field):.6f} W/m/K" for field in fields),
        f"{np.max(np.abs(fields[1] / fields[0] - 1)):.1e}",
        *(f"{read(folder / 'result.json')['seconds']:.0f}" for folder in (processor, gpu)),
    ]


def of_verdicts(processor: Path, gpu: Path) -> list[Any]:
    """What was said, the largest relative difference of a strength, seconds."""
    both = [read(folder / "verdict.json") for folder in (processor, gpu)]
    strengths = [[one["strength"] for one in each["rounds"]] for each in both]
    pairs = zip(*strengths, strict=False)
    apart = max((abs(second / first - 1) for first, second in pairs), default=None)
    return [
        *(" ".join([each["verdict"], *each["effects"]]) for each in both),
        "" if apart is None else f"{apart:.1e}",
        *(f"{each['seconds']:.0f}" for each in both),
    ]


def read(file: Path) -> dict[str, Any]:
    """A JSON file."""
    return json.loads(file.read_text("utf-8"))


if __name__ == "__main__":
    main()
