"""Forward run and gradient of a cooling sphere, against a hand-written SciPy loop.

    python benchmarks/sphere_against_scipy.py --peers FOLDER --python PYTHON [--table FILE]

FOLDER holds `problem.py` and `baseline_scipy.py` of the peer comparison, PYTHON is an interpreter
with numpy, scipy, gmsh and scikit-fem. The problem: 600 implicit Euler steps of 0.1 s on linear
cells, convection and radiation linearised at the old step, 11 787 nodes, and the gradient of a
mean squared misfit by the conductivity of each cell. The baseline solves by conjugate gradients
with the diagonal. Each is timed REPEATS times, in turns and on the same machine; the least counts,
and compilation is reported apart. `error_K` is the largest difference from the baseline run with
a tolerance of 1e-14, at the surface nodes after the last step.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import tempfile
import time
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from scipy.spatial import KDTree

from thermo.mesh import mesh_from_cells
from thermo.physics import ConjugateGradient, Model, ReadOut, discretise, solve_heat, uniform_steps
from thermo.physics.effects import Convection, Radiation
from thermo.physics.integrators import BackwardEuler

STEPS, SIZE, REPEATS = 600, 0.1, 3
DENSITY, HEAT_CAPACITY, CONDUCTIVITY = 1030.0, 1440.0, 0.1997
START, SURROUNDINGS, CONVECTION, EMISSIVITY = 295.15, 258.15, 3.0, 0.92
HEADER = ("solver", "rtol", "compile_s", "forward_s", "gradient_s", "error_K")


def baseline(given: argparse.Namespace, folders: dict[str, str], **more: str) -> dict[str, dict]:
    """What the SciPy loop reports of its forward run and of its gradient."""
    command = [given.python, "baseline_scipy.py", "s12k", "rock", "1", "jacobi", "grad"]
    environment = {**os.environ, **folders, "OPENBLAS_NUM_THREADS": "1", **more}
    done = subprocess.run(
        command, cwd=given.peers, env=environment, check=True, capture_output=True, text=True
    )
    lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    return {line["task"]: line for line in lines}


def sphere(data: Path) -> tuple[Model, ReadOut, np.ndarray]:
    """The model, a read-out of its surface nodes, and where they stand in the given numbering."""
    with (data / "s12k.npz").open("rb") as stream, np.load(stream) as stored:
        points, cells = stored["points"], stored["tets"]
    space = discretise(mesh_from_cells(points, cells))
    faces, cells = len(space.mesh.faces), len(space.mesh.cells)
    surface = (
        Convection(jnp.full(faces, CONVECTION), SURROUNDINGS),
        Radiation(jnp.full(faces, EMISSIVITY), SURROUNDINGS),
    )
    capacity = jnp.full(cells, DENSITY * HEAT_CAPACITY)
    model = Model(space, jnp.full(cells, CONDUCTIVITY), capacity, surface)
    nodes = np.unique(space.mesh.faces)
    place = KDTree(points).query(space.mesh.nodes[nodes])[1]
    readout = ReadOut(nodes[:, None].astype(np.int32), np.ones((len(nodes), 1)))
    return model, readout, np.argsort(place)


def clock(function, *arguments) -> tuple[np.ndarray, float, float]:  # noqa: ANN001, ANN002
    """Result, seconds of the first call beyond the least, and the least of REPEATS calls [s]."""
    begun = time.monotonic()
    result = jax.block_until_ready(function(*arguments))
    first = time.monotonic() - begun
    least = np.inf
    for _ in range(REPEATS):
        begun = time.monotonic()
        result = jax.block_until_ready(function(*arguments))
        least = min(least, time.monotonic() - begun)
    return np.asarray(result), max(first - least, 0.0), least


def ours(data: Path, reference: np.ndarray, rtol: float) -> dict:
    """One line of the table."""
    model, readout, order = sphere(data)
    grid = uniform_steps(np.arange(1, STEPS + 1) * SIZE, SIZE)
    initial = jnp.full(len(model.space.mesh.nodes), START)

    def forward(conductivity: jax.Array) -> jax.Array:
        changed = eqx.tree_at(lambda m: m.conductivity, model, conductivity)
        solver = ConjugateGradient(rtol=rtol)
        return solve_heat(
            changed, initial, grid, integrator=BackwardEuler(), readout=readout, solver=solver
        ).temperature

    run, compiling, seconds = clock(jax.jit(forward), model.conductivity)
    target = jnp.asarray(run + 0.01)

    def misfit(conductivity: jax.Array) -> jax.Array:
        return ((forward(conductivity) - target) ** 2).mean()

    _, more, slope = clock(jax.jit(jax.grad(misfit)), model.conductivity)
    error = float(np.abs(run[-1][order] - reference).max())
    return {
        "solver": "thermofield",
        "rtol": rtol,
        "compile_s": compiling + more,
        "forward_s": seconds,
        "gradient_s": slope,
        "error_K": error,
    }


def main() -> None:
    """Run both in turns and print the table."""
    parser = argparse.ArgumentParser(description="Against a hand-written SciPy loop.")
    parser.add_argument("--peers", type=Path, required=True)
    parser.add_argument("--python", required=True)
    parser.add_argument("--work", type=Path, default=Path(tempfile.gettempdir()) / "peers")
    parser.add_argument("--table", type=Path, help="CSV file for the results")
    given = parser.parse_args()
    folders = {"PEERS_DATA": str(given.work / "data"), "PEERS_OUT": str(given.work / "out")}
    if not (given.work / "data" / "s12k.npz").exists():
        command = [given.python, "problem.py", folders["PEERS_DATA"]]
        subprocess.run(command, cwd=given.peers, check=True)
    stored = given.work / "out" / "ref_s12k_rock_o1.npz"
    if not stored.exists():
        baseline(given, folders, RTOL="1e-14", SAVE_REF="1")
    with stored.open("rb") as stream, np.load(stream) as archive:
        reference = archive["surf"][-1]
    theirs: list[dict] = []
    rows = []
    for rtol in (1e-4, 2e-5, 1e-5):
        told = baseline(given, folders)
        theirs.append(told)
        rows.append(ours(given.work / "data", reference, rtol))
    least = {task: min(told[task]["seconds"] for told in theirs) for task in ("forward", "grad")}
    first = {
        "solver": "scipy jacobi", "rtol": 1e-10, "compile_s": 0.0, "forward_s": least["forward"],
        "gradient_s": least["grad"], "error_K": theirs[0]["forward"]["diff_K"],
    }  # fmt: skip
    for line in (first, *rows):
        cells = [f"{k}={v:.4g}" if isinstance(v, float) else f"{k}={v}" for k, v in line.items()]
        print("  ".join(cells))
    for line in rows:
        forward, slope = (line[key] / first[key] for key in ("forward_s", "gradient_s"))
        print(f"rtol {line['rtol']:g}, over SciPy: forward {forward:.2f}, gradient {slope:.2f}")
    if given.table:
        with given.table.open("w", newline="") as stream:
            writer = csv.DictWriter(stream, HEADER)
            writer.writeheader()
            writer.writerows(
                {k: f"{v:.4g}" if isinstance(v, float) else v for k, v in line.items()}
                for line in (first, *rows)
            )


if __name__ == "__main__":
    main()
