"""Every solver on every problem, each measurement in a process of its own.

    python benchmarks/speed/run.py [--full] [--meshes FOLDER] [--only PART]

Prints a table and writes `benchmarks/results/latest.json`, `speed.csv` and `speed.png` beside it.
`--full` adds the large bodies, which take most of an hour and up to 24 GiB. FOLDER holds
`s3k.npz`, `s12k.npz` and `s50k.npz` with `points` and `tets`, in place of structured balls.

JAX-FEM and DOLFINx join in runs of 100 steps where THERMOFIELD_JAX_FEM and THERMOFIELD_DOLFINX
name a Python that has them; `jax_fem_loop.py` and `dolfinx_loop.py` say how to get one. The bunny
is read from `scenes/bunny` in the folder THERMOFIELD_DATA, or left out.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import shutil
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
STEPS, FEW, SHORT = 600, 60, 100

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
# A step of JAX-FEM takes 0.05 to 0.5 s, so that all run only the first ones.
SHARED = (
    ("s3k-rock", SHORT, ("forward", "gradient")),
    ("s12k-rock", SHORT, ("forward", "gradient")),
)
# The gradient of few steps is small, and the quadratic ball of rock needs more digits: a tighter
# tolerance of ours keeps them within 1e-4 and 1e-5 K.
TIGHT = ("--rtol", "1e-5")
# Who, the variable that names a Python that has it, the script for that Python, and its tasks.
PEERS = (
    ("jax-fem", "THERMOFIELD_JAX_FEM", "jax_fem_loop.py", ("forward", "gradient")),
    ("dolfinx", "THERMOFIELD_DOLFINX", "dolfinx_loop.py", ("forward",)),
)
LARGE = ("s200k", "s1m")
ADAPTIVE = "bunny-heating-adaptive"
FIELDS = ("problem", "who", "task", "nodes", "steps", "cpu_ms_per_step", "cpu_s", "wall_s",
          "compile_s", "peak_gb", "base_gb", "diff_K", "gradient_error", "rtol")  # fmt: skip


UNITS = (("cpu_ms_per_step", "ms/step"), ("cpu_s", "s"), ("compile_s", "s compile"),
         ("peak_gb", "GB"), ("diff_K", "K"), ("gradient_error", "of gradient"))  # fmt: skip


def measure(script: str, *arguments: str, python: str = sys.executable) -> list[dict[str, Any]]:
    """What one process printed; nothing, but a line of why, where it failed."""
    command = [python, str(HERE / script), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        reason = (done.stderr.strip() or f"exit code {done.returncode}").splitlines()[-1]
        print(f"left out: {script} {' '.join(arguments[:4])}: {reason}", flush=True)
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


def find_peers() -> list[tuple[str, str, tuple[str, ...]]]:
    """Python, script and tasks of each peer that the environment names; a line for each other."""
    found = []
    for who, variable, script, tasks in PEERS:
        python = os.environ.get(variable)
        if python is None:
            print(f"left out: {who}: name a Python that has it with {variable}")
        elif shutil.which(python) is None:
            print(f"left out: {who}: {variable} names {python}, which cannot be run")
        else:
            found.append((python, script, tasks))
    return found


def compare(problem: tuple, given: Any, folder: Path, peers: list) -> list[dict]:
    """All measurements of one problem; SciPy, ours and the peers in turns."""
    name, steps, tasks = problem
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
            tight = who == "thermo" and (problem in SHARED or name == "s12k-tet10-rock")
            rtol = TIGHT if tight else ()
            found = measure("measure.py", name, str(steps), who, task, *reference, *where, *rtol)
            records += found
            show(*found)
        for python, script, able in peers:
            if task in able and problem in SHARED:
                found = measure(script, task, *reference, python=python)
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


def ratios(records: list[dict]) -> None:
    """Print our processor time over that of each other on the same problem."""
    cost = {identity(record): record["cpu_s"] for record in records}
    others = {"scipy": "the SciPy loop", "jax-fem": "JAX-FEM", "dolfinx": "DOLFINx"}
    for record in records:
        for who, name in others.items() if record["who"] == "thermo" else ():
            theirs = cost.get((*identity(record)[:-1], who))
            if theirs is not None:
                print(f"{record['problem']}-{record['steps']} {record['task']}: "
                      f"{record['cpu_s'] / theirs:.2g} of {name}'s")  # fmt: skip


def write(path: Path, text: str) -> None:
    """Replace a file at once."""
    part = path.with_suffix(path.suffix + ".part")
    part.write_text(text)
    part.replace(path)


def main() -> None:
    """Run all, print the table, write the results."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--full", action="store_true", help="the large bodies as well")
    parser.add_argument("--meshes", help="folder of meshes in place of structured balls")
    parser.add_argument(
        "--only",
        default="",
        help="problems whose names contain this; the rest of the results stays",
    )
    given = parser.parse_args()
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NPROC"):
        os.environ[name] = "1"
    problems = (*(FULL if given.full else QUICK), *SHARED)
    chosen = [problem for problem in problems if given.only in f"{problem[0]}-{problem[1]}"]
    if not chosen and given.only not in ADAPTIVE:
        names = " ".join(f"{name}-{steps}" for name, steps, _ in problems)
        parser.error(f"--only {given.only}: no problem's name contains it, of {names} {ADAPTIVE}")
    begun, records = time.monotonic(), []
    # Each compiles for itself, so that the seconds of compiling are those of a new machine.
    os.environ["JAX_ENABLE_COMPILATION_CACHE"] = "false"
    with tempfile.TemporaryDirectory() as place:
        peers = find_peers() if set(chosen) & set(SHARED) else []
        for problem in chosen:
            records += compare(problem, given, Path(place), peers)
    if given.only in ADAPTIVE:
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
    ratios(records)
    print(f"{time.monotonic() - begun:.0f} s")


if __name__ == "__main__":
    main()
