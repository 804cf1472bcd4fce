"""What coarser spaces save the conjugate gradients, by how far heat goes in a step.

    python benchmarks/coarse_spaces.py

Balls of aluminium in linear and in quadratic cells, weights of a step from ones in which heat stays
in a cell to ones in which it goes through the body; right-hand sides that are rough on the surface,
as under a lamp, solved to 1e-4 from nothing with the diagonal alone and with the coarser spaces
beside it. `ratio` is what `PAYS` and `WORTH` are limits of: conducted over stored heat of a corner,
on average. Prints iterations and the least milliseconds of five solves, and writes
benchmarks/results/coarse_spaces.csv.
"""

from __future__ import annotations

import csv
import sys
import time
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "speed"))

from problem import make_problem  # noqa: E402

from thermo.physics import (  # noqa: E402
    ConjugateGradient,
    Model,
    StepMatrix,
    _coarse_correction,
    assemble,
    discretise,
    step_matrix,
)

PROBLEMS = ("s12k-alu", "s50k-alu", "s3k-tet10-alu", "s12k-tet10-alu")
WEIGHTS = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0, 100.0)
FAR = 1e3
"""Reach [m2] with which the coarser spaces are always made."""


@eqx.filter_jit
def made(model: Model, weight: jax.Array) -> tuple[StepMatrix, jax.Array]:
    """The matrix of a step [J/K], and the ratio of its conducted to its stored heat [1]."""
    balance = assemble(model)
    coarse = balance.coarse
    assert coarse is not None
    matrix = step_matrix(balance, jnp.full(len(model.space.mesh.nodes), 300.0), weight)
    return matrix, weight * coarse.rate


@eqx.filter_jit
def solved(matrix: StepMatrix, heat: jax.Array) -> jax.Array:
    """Iterations [1]."""
    return ConjugateGradient(rtol=1e-4).solve(matrix, heat, jnp.zeros_like(heat))[2]


def timed(matrix: StepMatrix, heat: jax.Array) -> tuple[int, float]:
    """Iterations [1], and the least time of five solves [ms]."""
    count, least = int(solved(matrix, heat)), np.inf
    for _ in range(5):
        begun = time.perf_counter()
        jax.block_until_ready(solved(matrix, heat))
        least = min(least, time.perf_counter() - begun)
    return count, 1e3 * least


def main() -> None:
    """Print the table and write it."""
    rows = []
    _coarse_correction.WORTH = 0.0  # they are to be used in short steps as well
    for name in PROBLEMS:
        problem = make_problem(name, 1)
        space = discretise(problem.mesh, FAR)
        cells = len(space.mesh.cells)
        model = Model(space, jnp.asarray(problem.conductivity), jnp.full(cells, problem.capacity))
        inner = space.pattern.inner
        lit = np.random.default_rng(0).random(len(space.mesh.nodes) - inner)
        heat = jnp.asarray(np.pad(lit, (inner, 0)))
        for weight in WEIGHTS:
            matrix, ratio = made(model, jnp.asarray(weight))
            alone, beside = (
                timed(one, heat) for one in (eqx.tree_at(lambda m: m.coarse, matrix, None), matrix)
            )
            numbers = (ratio, alone[0], beside[0], alone[1], beside[1])
            rows.append((name, len(heat), weight, *(f"{float(value):.3g}" for value in numbers)))
            print(*rows[-1], flush=True)
    with (HERE / "results" / "coarse_spaces.csv").open("w", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(
            ("problem", "nodes", "weight_s", "ratio", "iterations", "with_spaces", "ms", "with_ms")
        )
        table.writerows(rows)


if __name__ == "__main__":
    main()
