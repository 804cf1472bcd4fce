"""What single precision hides of a residual: `ROUNDING` of the conjugate gradients is twice that.

Balls of aluminium, steps of 0.1 to 100 s, and right-hand sides from rough to what constant
temperatures ask for, which is the hardest, solved in single precision as far as it goes. Prints the
true residual over the solution, both in the norm of the diagonal, in units of the rounding.

    python benchmarks/rounding.py

Writes `benchmarks/results/rounding.csv`.
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

from thermo.physics import ConjugateGradient, Model, assemble, step_matrix  # noqa: E402


@eqx.filter_jit
def hidden(model: Model, weight: jax.Array, waves: jax.Array) -> jax.Array:
    """For each solution [K] the residual that is left of its right-hand side, (solutions,) [1]."""
    matrix = step_matrix(assemble(model), jnp.full(len(waves), 300.0), weight)
    rough = matrix.diagonal[:, None] * waves[:, -1:]
    heat = jnp.concatenate([matrix.mv(waves), rough], 1)
    heat = heat / jnp.linalg.norm(heat / jnp.sqrt(matrix.diagonal)[:, None], axis=0)
    single = jax.tree.map(
        lambda a: a.astype(jnp.float32) if eqx.is_inexact_array(a) else a, (matrix, heat)
    )
    found, *_ = ConjugateGradient(rtol=1e-7).solve(*single, 0 * single[1])
    left = heat - matrix.mv(found.astype(heat.dtype))
    root = jnp.sqrt(matrix.diagonal)[:, None]
    return jnp.linalg.norm(left / root, axis=0) / jnp.linalg.norm(root * found, axis=0)


def main() -> None:
    """Print the table and write it to `results/rounding.csv`."""
    rows = []
    for name in ("s12k-alu", "s50k-alu", "s12k-tet10-alu"):
        model = Ours(make_problem(name, 1), 1e-7).model
        nodes = jnp.asarray(model.space.mesh.nodes)
        noise = jnp.asarray(np.random.default_rng(0).normal(size=len(nodes)))
        waves = jnp.stack([jnp.ones(len(nodes)), 1 + jnp.sin(60 * nodes[:, 0]), noise], 1)
        for weight in (0.1, 1.0, 10.0, 100.0):
            found = hidden(model, jnp.asarray(weight), waves) / jnp.finfo(jnp.float32).eps
            rows.append((name, weight, *(f"{value:.2f}" for value in found)))
            print(*rows[-1])
    with (HERE / "results" / "rounding.csv").open("w", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(("problem", "weight_s", "constant", "wave", "noise", "rough_heat"))
        table.writerows(rows)


if __name__ == "__main__":
    main()
