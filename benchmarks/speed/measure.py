"""One measurement in a process of its own; prints one line of JSON.

python measure.py PROBLEM STEPS WHO TASK --reference FILE [--meshes FOLDER] [--rtol R]
"""

from __future__ import annotations

import argparse
import json
import os
import time
from pathlib import Path
from typing import Any

# One thread each: what counts is the processor's time, and a second thread costs more than it
# gives on problems of this size.
for name in ("NPROC", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np  # noqa: E402
from problem import Problem, as_arrays, make_problem  # noqa: E402
from scipy.spatial import KDTree  # noqa: E402
from timing import clock, peak_gb  # noqa: E402


def scipy_run(problem: Problem, task: str, reference: Path, rtol: float) -> dict[str, Any]:
    """The SciPy loop; with a tight tolerance it writes the reference, and the problem with it."""
    from scipy_loop import Loop

    tight = task == "reference"
    loop = Loop(problem, 1e-13 if tight else rtol)
    base = peak_gb()
    if tight:
        target = loop.forward(problem.other)
        run = loop.forward(problem.conductivity)
        slope = loop.gradient(problem.conductivity, target)
        places = loop.places[np.argsort(loop.place)][loop.nodes]
        part = reference.with_suffix(".part.npz")
        given = as_arrays(problem)
        np.savez(part, run=run, target=target, slope=slope, places=places, **given)
        part.rename(reference)
        return {}
    with reference.open("rb") as stream, np.load(stream) as stored:
        exact, target, slope = stored["run"], stored["target"], stored["slope"]
    out: dict[str, Any] = {"compile_s": 0.0}
    if task == "forward":
        found, out["cpu_s"], out["wall_s"] = clock(loop.forward, problem.conductivity)
        out["diff_K"] = float(np.abs(found - exact)[-1].max())
    else:
        found, out["cpu_s"], out["wall_s"] = clock(loop.gradient, problem.conductivity, target)
        out["gradient_error"] = float(np.linalg.norm(found - slope) / np.linalg.norm(slope))
    return {**out, "base_gb": base, "rtol": rtol}


def our_run(problem: Problem, task: str, reference: Path | None, rtol: float) -> dict[str, Any]:
    """ThermoField, compiled first."""
    import jax
    import jax.numpy as jnp
    from ours import COLUMNS, Ours

    imported = peak_gb()
    ours = Ours(problem, rtol, "segments" if task.endswith("-segments") else "store")
    exact = slope = None
    order = np.arange(len(ours.places))
    target = np.zeros((problem.steps, len(ours.places)))
    if reference is not None:
        with reference.open("rb") as stream, np.load(stream) as stored:
            order = KDTree(stored["places"]).query(ours.places)[1]
            exact, slope = stored["run"][:, order], stored["slope"]
            target = stored["target"][:, order]
    conductivity = jnp.asarray(problem.conductivity)
    if task.startswith("gradient"):
        function = ours.gradient(jnp.asarray(target))
    else:
        function = ours.jacobian() if task == f"jacobian{COLUMNS}" else ours.forward()
    begun = time.perf_counter()
    jax.block_until_ready(function(conductivity))
    first = time.perf_counter() - begun
    found, cpu, wall = clock(lambda: jax.block_until_ready(function(conductivity)))
    out = {"cpu_s": cpu, "wall_s": wall, "compile_s": max(first - wall, 0.0), "rtol": rtol}
    if task == "forward" and exact is not None:
        out["diff_K"] = float(np.abs(np.asarray(found) - exact)[-1].max())
    if task.startswith("gradient") and slope is not None:
        error = np.linalg.norm(np.asarray(found) - slope) / np.linalg.norm(slope)
        out["gradient_error"] = float(error)
    return {**out, "base_gb": imported}


def main() -> None:
    """Measure once."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("problem")
    parser.add_argument("steps", type=int)
    parser.add_argument("who", choices=("thermo", "scipy"))
    parser.add_argument("task")
    parser.add_argument("--reference", type=Path)
    parser.add_argument("--meshes")
    parser.add_argument("--rtol", type=float)
    given = parser.parse_args()
    problem = make_problem(given.problem, given.steps, given.meshes)
    run = our_run if given.who == "thermo" else scipy_run
    rtol = given.rtol or (2e-5 if given.who == "thermo" else 1e-10)
    out = run(problem, given.task, given.reference, rtol)
    record = {
        "problem": given.problem,
        "who": given.who,
        "task": given.task,
        "nodes": len(problem.mesh.nodes),
        "steps": given.steps,
        "peak_gb": peak_gb(),
        **out,
    }
    if "cpu_s" in out:
        record["cpu_ms_per_step"] = 1e3 * out["cpu_s"] / given.steps
    print(json.dumps(record))


if __name__ == "__main__":
    main()
