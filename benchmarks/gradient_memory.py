"""Memory of a gradient against the number of steps, kept whole and in segments.

A ball of 12 431 nodes, implicit Euler steps, the gradient by each cell's conductivity of the
temperature at one node: what the compiled program asks for beside its inputs and outputs, and the
exponents from each number of steps to the next. Few steps need less than the assembly before them.

    python benchmarks/gradient_memory.py

Writes `benchmarks/results/gradient_memory.csv`.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "speed"))

from ours import Ours  # noqa: E402
from problem import make_problem  # noqa: E402

from thermo.physics import Model, ReadOut  # noqa: E402

STEPS = (600, 2400, 9600, 38400, 153600)


def temporary_gb(steps: int, adjoint: str) -> float:
    """Memory [GB] of the compiled gradient."""
    ours = Ours(make_problem("s12k-rock", steps), 2e-5, adjoint)
    nodes = np.array([[len(ours.space.mesh.nodes) - 1]], np.int32)
    ours.readout = ReadOut(nodes, np.ones((1, 1)))
    conductivity, target = jnp.asarray(ours.problem.conductivity), jnp.zeros((steps, 1))

    def slope(model: Model, conductivity: jax.Array, target: jax.Array) -> jax.Array:
        def misfit(k: jax.Array) -> jax.Array:
            return jnp.mean((ours.run(model, k) - target) ** 2)

        return jax.grad(misfit)(conductivity)

    program = eqx.filter_jit(slope).lower(ours.model, conductivity, target).compile()
    return program.compiled.memory_analysis().temp_size_in_bytes / 1e9


def main() -> None:
    """Print the table and write it to `results/gradient_memory.csv`."""
    rows = [
        (steps, *(temporary_gb(steps, way) for way in ("store", "segments"))) for steps in STEPS
    ]
    with (HERE / "results" / "gradient_memory.csv").open("w", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(("steps", "store_gb", "segments_gb"))
        table.writerows((steps, *(f"{size:.4g}" for size in sizes)) for steps, *sizes in rows)
    steps, store, segments = np.array(rows).T
    for name, size in (("store", store), ("segments", segments)):
        rate = np.diff(np.log(size)) / np.diff(np.log(steps))
        print(f"{name}: {np.round(size, 3).tolist()} GB at {steps.astype(int).tolist()} steps, "
              f"exponents {np.round(rate, 2).tolist()}")  # fmt: skip


if __name__ == "__main__":
    main()
