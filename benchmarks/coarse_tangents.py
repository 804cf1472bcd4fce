"""How far coarse tangents are from the true ones, and what they promise where nothing is left.

For the bracket, on 16 control points without a prior: the relative difference of both dense
Jacobians, and the gain that the coarse one promises, as a share of the loss, at the minimum of the
problem linearised by the true one. At the uniform start and one step on.

    python benchmarks/coarse_tangents.py
"""

from __future__ import annotations

import csv
import sys
from dataclasses import replace
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from thermo.inverse import LevenbergMarquardt, Meshing, OnControlPoints, Prior, Stepping
from thermo.inverse._objective import jacobian, start
from thermo.inverse._stages import make_objective
from thermo.inverse._task import Task, prepare
from thermo.observe import read_scene

HERE = Path(__file__).parent


def main() -> None:
    """Print the table and write it to `results/coarse_tangents.csv`."""
    scene = read_scene(HERE.parent / "examples" / "bracket")
    runs = tuple(run for run in scene.runs.values() if not run.held_out)
    how = (OnControlPoints(16), LevenbergMarquardt(), Prior(step=1e6), Stepping(), Meshing())
    task = Task(scene, runs, ("conductivity",), *how, "none", {}, 0, 0.01)
    objective = make_objective(task, prepare(task), 2)
    if objective.tangents is None:
        sys.exit("this fit takes no coarse tangents")
    dense = eqx.filter_jit(jacobian)
    parameters, rows = start(objective), []
    for place in ("uniform start", "one step on"):
        coarse = np.asarray(dense(objective.tangents, parameters)[1])
        value, true = map(np.asarray, dense(replace(objective, tangents=None), parameters))
        step = np.linalg.lstsq(true, -value, rcond=None)[0]
        least = value + true @ step
        change = coarse @ np.linalg.lstsq(coarse, -least, rcond=None)[0]
        rows.append(
            {
                "place": place,
                "difference": f"{np.linalg.norm(coarse - true) / np.linalg.norm(true):.3f}",
                "promise": f"{-(change @ (least + 0.5 * change)) / (0.5 * least @ least):.2e}",
            }
        )
        print(rows[-1], flush=True)
        parameters = jax.tree.map(lambda raw: raw + jnp.clip(step, -1, 1), parameters)  # noqa: B023
    with (HERE / "results" / "coarse_tangents.csv").open("w", newline="") as stream:
        table = csv.DictWriter(stream, rows[0])
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    main()
