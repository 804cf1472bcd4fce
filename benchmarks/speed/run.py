"""Every solver on every problem, each measurement in a process of its own.

    python benchmarks/speed/run.py [--full] [--meshes FOLDER] [--only PART]

Prints a table and writes `benchmarks/results/latest.json`, `speed.csv` and `speed.png` beside it.
`--full` adds the large bodies, which take most of an hour and up to 24 GiB. FOLDER holds
`s3k.npz`, `s12k.npz` and `s50k.npz` with `points` and `tets`, in place of structured balls.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

HERE = Path(__file__).resolve().parent
RESULTS = HERE.parent / "results"
STEPS, FEW = 600, 60

# Problem, steps, and the tasks of each; the adaptive one is described in `adaptive.py`.
QUICK = (
    ("s3k-rock", STEPS, ("forward", "gradient")),
    ("s12k-rock", STEPS, ("forward", "gradient", "gradient-segments", "jacobian32")),
    ("s12k-alu", STEPS, ("forward", "gradient")),
    ("s50k-rock", 100, ("forward", "gradient")),
    ("s12k-tet10-rock", FEW, ("forward",)),
)
FULL = (
    ("s3k-rock", STEPS, ("forward", "gradient")),
    ("s3k-alu", STEPS, ("forward", "gradient")),
    ("s12k-rock", STEPS, ("forward", "gradient", "gradient-segments", "jacobian32")),
    ("s12k-alu", STEPS, ("forward", "gradient", "jacobian32")),
    ("s50k-rock", STEPS, ("forward", "gradient")),
    ("s50k-alu", STEPS, ("forward", "gradient")),
    ("s12k-tet10-rock", STEPS, ("forward",)),
    ("s12k-tet10-alu", FEW, ("forward",)),
    ("s3k-rock", FEW, ("forward", "gradient")),
    ("s12k-rock", FEW, ("forward", "gradient")),
    ("s50k-rock", FEW, ("forward", "gradient")),
    ("s200k-rock", FEW, ("forward", "gradient")),
    ("s1m-rock", FEW, ("forward", "gradient-segments")),
)
LARGE = ("s200k", "s1m")
FIELDS = ("problem", "who", "task", "nodes", "steps", "cpu_ms_per_step", "cpu_s", "wall_s",
          "compile_s", "peak_gb", "base_gb", "diff_K", "gradient_error", "rtol")  # fmt: skip


UNITS = (("cpu_ms_per_step", "ms/step"), ("cpu_s", "s"), ("compile_s", "s compile"),
         ("peak_gb", "GB"), ("diff_K", "K"), ("gradient_error", "of gradient"))  # fmt: skip


def measure(script: str, *arguments: str) -> list[dict[str, Any]]:
    """What one process printed; nothing, but a line of why, where it failed."""
    command = [sys.executable, str(HERE / script), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        reason = (done.stderr.strip() or f"exit code {done.returncode}").splitlines()[-1]
        print(f"left out: {' '.join(arguments[:4])}: {reason}", flush=True)
        return []
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]


def show(*records: dict[str, Any]) -> None:
    """A line of the table for each."""
    for record in records:
        cells = [f"{record['problem']:24}{record['who']:9}{record['task']:18}"]
        for name, unit in UNITS:
            if record.get(name) is not None:
                cells.append(f"{record[name]:9.3g} {unit}")
        print("  ".join(cells), flush=True)


def compare(name: str, steps: int, tasks: tuple[str, ...], given: Any, folder: Path) -> list[dict]:
    """All measurements of one problem; SciPy and ours in turns."""
    where = ("--meshes", given.meshes) if given.meshes else ()
    reference: tuple[str, ...] = ()
    large = name.split("-")[0] in LARGE
    if not large:
        reference = ("--reference", str(folder / f"{name}-{steps}.npz"))
        measure("measure.py", name, str(steps), "scipy", "reference", *reference, *where)
    records = []
    for task in tasks:
        # The loop by hand has no Jacobian; on a million nodes only ours is asked.
        both = ("scipy", "thermo") if task in ("forward", "gradient") and not large else ("thermo",)
        for who in both:
            found = measure("measure.py", name, str(steps), who, task, *reference, *where)
            records += found
            show(*found)
    return records


def adaptive(data: str | None) -> list[dict]:
    """The bunny's minute of heating, where its recording is at hand."""
    folder = Path(data or HERE.parents[1] / "data")
    if not (folder / "scenes" / "bunny").exists():
        print(f"left out: bunny-heating-adaptive: no scenes/bunny in {folder}; "
              "name its folder with THERMOFIELD_DATA")  # fmt: skip
        return []
    records = measure("adaptive.py", "--data", str(folder))
    show(*records)
    return records


def identity(record: dict[str, Any]) -> tuple:
    """What a record is of; planned steps stand beside those of the loop, whatever their number."""
    planned = record["problem"].endswith("adaptive")
    steps = None if planned else record["steps"]
    return record["mesh"], record["problem"], steps, record["task"], record["who"]


def picture(records: list[dict], path: Path) -> None:
    """Cost of a step against nodes, poor conductor, and the fitted exponents.

    Of runs of the same number of steps, since the first ones take the most iterations.
    """
    steps = FEW if any(r["steps"] == FEW and r["problem"] == "s1m-rock" for r in records) else STEPS
    figure, axes = plt.subplots(figsize=(5.5, 4), layout="constrained")
    for who in ("scipy", "thermo"):
        for task, style in (("forward", "o-"), ("gradient", "s--")):
            lines = [
                (r["nodes"], r["cpu_ms_per_step"])
                for r in records
                if r["who"] == who
                and r["task"].removesuffix("-segments") == task
                and r["steps"] == steps
                and r["problem"].count("-") == 1
                and r["problem"].endswith("rock")
            ]
            chosen = dict(sorted(lines))
            if len(chosen) > 1:
                nodes, cost = (np.array(part) for part in zip(*chosen.items(), strict=True))
                rate = np.polyfit(np.log(nodes), np.log(cost), 1)[0]
                axes.loglog(nodes, cost, style, label=f"{who}, {task}: {rate:.2f}")
                print(f"exponent of {who}, {task}: {rate:.2f} over {nodes.tolist()} nodes")
    axes.set(xlabel="nodes", ylabel=f"processor time of a step of {steps} [ms]")
    axes.legend(title="exponent", fontsize=8)
    figure.savefig(path, dpi=120)


def write(path: Path, text: str) -> None:
    """Replace a file at once."""
    part = path.with_suffix(path.suffix + ".part")
    part.write_text(text)
    part.replace(path)


def main() -> None:
    """Run all, print the table, write the results."""
    parser = argparse.ArgumentParser(description="ThermoField beside other solvers.")
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--meshes", help="folder of meshes in place of structured balls")
    parser.add_argument(
        "--only",
        default="",
        help="problems whose names contain this; the rest of the results stays",
    )
    given = parser.parse_args()
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NPROC"):
        os.environ[name] = "1"
    begun, records = time.monotonic(), []
    # Each compiles for itself, so that the seconds of compiling are those of a new machine.
    os.environ["JAX_ENABLE_COMPILATION_CACHE"] = "false"
    with tempfile.TemporaryDirectory() as place:
        for name, steps, tasks in FULL if given.full else QUICK:
            if given.only in f"{name}-{steps}":
                records += compare(name, steps, tasks, given, Path(place))
    if given.only in "bunny-heating-adaptive":
        records += adaptive(os.environ.get("THERMOFIELD_DATA"))
    for record in records:
        record["mesh"] = "given" if given.meshes else "structured"
    RESULTS.mkdir(exist_ok=True)
    latest = RESULTS / "latest.json"
    if given.only and latest.exists():
        fresh = {identity(record) for record in records}
        records = [r for r in json.loads(latest.read_text()) if identity(r) not in fresh] + records
    write(latest, json.dumps(records, indent=1) + "\n")
    with (RESULTS / "speed.csv").open("w", newline="") as stream:
        table = csv.DictWriter(stream, FIELDS, extrasaction="ignore")
        table.writeheader()
        table.writerows(
            {k: f"{v:.4g}" if isinstance(v, float) else v for k, v in r.items()} for r in records
        )
    picture(records, RESULTS / "speed.png")
    theirs = {identity(r)[:-1]: r["cpu_s"] for r in records if r["who"] == "scipy"}
    for record in records:
        loop = theirs.get(identity(record)[:-1])
        if loop is not None and record["who"] != "scipy":
            ratio = record["cpu_s"] / loop
            print(f"{record['problem']} {record['task']}: {ratio:.2f} of the SciPy loop's")
    print(f"{time.monotonic() - begun:.0f} s")


if __name__ == "__main__":
    main()
