"""How long programs take to compile and to run: what a gather is worth, and what XLA is asked for.

    python benchmarks/compiling.py

Rows of a matrix are padded to equal lengths in a few groups (`thermo.physics._pattern`): more
groups have less padding, and more gathers to compile. This asks for the best grouping at several
prices of a gather, and at the one in use both with what `thermo._compiled.program` asks of XLA and
as XLA does by itself (`asked`): the Jacobian of the bracket's run under its first lamp by one
conductivity, in quadratic cells of two sizes, and a forward run with its gradient, 300 steps, on a
ball of linear cells. `compile` and `run` are seconds of processor time, the latter the least of
five. Writes benchmarks/results/compiling.csv.
"""

from __future__ import annotations

import csv
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, cast

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from thermo._compiled import _options as asking
from thermo._remembered import forget
from thermo.inverse import Meshing, log_model
from thermo.inverse._objective import jacobian, start
from thermo.mesh import ball_mesh
from thermo.physics import Model, TimeGrid, discretise, solve_heat
from thermo.physics import _pattern as pattern
from thermo.physics.effects import Convection, Radiation
from thermo.physics.integrators import Sdirk2

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results" / "compiling.csv"
COSTS = (1000.0, 2000.0, 4000.0)
# By price, what XLA is asked for.
WAYS = [*((cost, True) for cost in COSTS), (pattern.GATHER_COST, False)]
COLUMNS = ("program", "nodes", "price", "asked", "gathers", "entries", "compile", "run")
STEPS, STEP = 300, 0.5  # s

Program = tuple[str, pattern.Pattern, Callable[..., Any], tuple[Any, ...]]


def programs() -> Iterator[Program]:
    """Name, pattern, function and arguments of each."""
    for nodes in (1500, 15_000):
        model = log_model(
            HERE.parent / "examples" / "bracket", runs=("heating_boss",),
            unknown=("conductivity",), initial={"conductivity": 1.5},
            meshing=Meshing(max_nodes=nodes, corrected=False),
        )  # fmt: skip
        given = (model.objective, start(model.objective))
        yield "Jacobian", model.objective.space.pattern, jacobian, given
    space = discretise(ball_mesh(0.05, 17))
    cells, faces = len(space.mesh.cells), len(space.mesh.faces)
    ends = STEP * np.arange(STEPS + 1)
    grid = TimeGrid(ends[:-1], np.full(STEPS, STEP), np.arange(STEPS + 1, dtype=np.int32), ends)
    surface = (
        Convection(jnp.full(faces, 10.0), 293.0), Radiation(jnp.full(faces, 0.9), 293.0),
    )  # fmt: skip

    def spread(conductivity: jax.Array) -> jax.Array:
        model = Model(
            space, conductivity=jnp.full(cells, conductivity), capacity=jnp.full(cells, 2e6),
            surface=surface,
        )  # fmt: skip
        warm = jnp.full(len(space.mesh.nodes), 350.0)
        return solve_heat(model, warm, grid, integrator=Sdirk2()).temperature.var()

    yield "forward", space.pattern, spread, (jnp.asarray(1.5),)
    yield "gradient", space.pattern, jax.grad(spread), (jnp.asarray(1.5),)


def timed(
    function: Callable[..., Any], given: tuple[Any, ...], *, asked: bool
) -> tuple[float, float]:
    """Seconds to compile, and to run at best."""
    # A program that came before is not compiled again.
    jax.clear_caches()
    options = asking() if asked else {}
    lowered = cast(Any, eqx.filter_jit)(function, compiler_options=options).lower(*given)
    begun = time.process_time()
    compiled = lowered.compile()
    compiling, runs = time.process_time() - begun, []
    for _ in range(5):
        begun = time.process_time()
        jax.block_until_ready(compiled(*given))
        runs.append(time.process_time() - begun)
    return compiling, min(runs)


def main() -> None:
    """Print the table and write it."""
    jax.config.update("jax_enable_compilation_cache", False)
    lines = []
    print(*COLUMNS)
    for cost, asked in WAYS:
        pattern.GATHER_COST = cost
        forget()
        for name, rows, function, given in programs():
            gathers = sum(block.shape[1] for block in rows.columns)
            entries = sum(block.size for block in rows.columns)
            nodes = rows.bounds[-1][1]
            seconds = (f"{one:.3g}" for one in timed(function, given, asked=asked))
            lines.append(
                [name, nodes, f"{cost:g}", "yes" if asked else "no", gathers, entries, *seconds]
            )
            print(*lines[-1], flush=True)
    with RESULTS.open("w", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows([COLUMNS, *lines])


if __name__ == "__main__":
    main()
