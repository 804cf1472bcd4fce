"""Does a third-order scheme pay? Its error for a number of solves beside that of the second order.

A ball of poor conductor under a lamp that goes off half way, in steps planned for several
tolerances; the reference has 3000 even steps. Errors are the largest at any surface node and frame.

    python benchmarks/third_order.py

Writes `benchmarks/results/third_order.csv`.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from thermo.mesh import ball_mesh
from thermo.physics import (
    Balance,
    ConjugateGradient,
    Model,
    TimeGrid,
    discretise,
    plan_steps,
    solve_heat,
    step_matrix,
    uniform_steps,
)
from thermo.physics._outlook import Memory, Outlook
from thermo.physics.effects import Convection, Heating, Radiation, Schedule, spot_profile
from thermo.physics.integrators import AbstractIntegrator, Sdirk2
from thermo.physics.integrators._integrator import Loop, Step, solve_stage, within

HERE = Path(__file__).parent
RADIUS, END, OFF = 0.03, 60.0, 30.0
TOLERANCES = (0.3, 0.1, 0.03, 0.01, 0.003, 0.001, 0.0003, 0.0001)
GAMMA = 0.43586652150845967
TABLE = (
    (),
    ((1 - GAMMA) / 2,),
    (-(6 * GAMMA**2 - 16 * GAMMA + 1) / 4, (6 * GAMMA**2 - 20 * GAMMA + 5) / 4),
)
TIMES = (GAMMA, (1 + GAMMA) / 2, 1.0)


@final
class Sdirk3(AbstractIntegrator):
    """Three implicit stages with one matrix, third order, L-stable; constant properties only.

    Source: Alexander, SIAM J. Numer. Anal. 14 (1977) 1006.
    """

    def order(self) -> int:
        """Order of accuracy [1]."""
        return 3

    def solves(self) -> int:
        """Three stages [1]."""
        return 3

    def weight(self, size: float | jax.Array) -> float | jax.Array:
        """Of the heat rates in the matrix of a step of `size` [s]; [s]."""
        return GAMMA * size

    def step(
        self,
        balance: Balance,
        temperature: jax.Array,
        start: float | jax.Array,
        size: float | jax.Array,
        solver: ConjugateGradient,
        past: Memory,
        outlook: Outlook,
        loop: Loop,
    ) -> Step:
        """One step of `size` [s] after `start` [s]."""
        del loop
        weight = self.weight(size)
        matrix = step_matrix(balance, temperature, weight)
        guess, value = temperature, temperature
        # What each stage's own heat raises the temperature by, over the step.
        slopes, fine = [], jnp.asarray(True)
        for number, (row, share) in enumerate(zip(TABLE, TIMES, strict=True)):
            base = temperature + sum(a * s for a, s in zip(row, slopes, strict=True))
            value, past, well = solve_stage(
                balance, guess, base, within(start, size, share), weight, temperature, matrix,
                solver, past, np.array([number]), outlook,
            )  # fmt: skip
            slopes.append((value - base) / GAMMA)
            fine = fine & well
            if number < 2:
                guess = temperature + (value - temperature) * TIMES[number + 1] / share
        return value, past, fine


def make_model() -> Model:
    """A ball under a lamp, with convection and radiation."""
    space = discretise(ball_mesh(RADIUS, 9))
    cells, faces = len(space.mesh.cells), len(space.mesh.faces)
    profile = spot_profile(
        space, centre=np.array([0, 0, RADIUS]), direction=np.array([0, 0, -1.0]), radius=0.02
    )
    surface = (
        Convection(jnp.full(faces, 10.0), 293.0),
        Radiation(jnp.full(faces, 0.9), 293.0),
        Heating(3.0, jnp.asarray(profile), Schedule(OFF)),
    )
    return Model(space, jnp.full(cells, 0.2), jnp.full(cells, 1.5e6), surface)


@eqx.filter_jit
def run(model: Model, grid: TimeGrid, scheme: AbstractIntegrator, rtol: float) -> jax.Array:
    """Temperatures [K] of all nodes at the frames."""
    start = jnp.full(len(model.space.mesh.nodes), 293.0)
    return solve_heat(
        model, start, grid, integrator=scheme, solver=ConjugateGradient(rtol=rtol)
    ).temperature


def main() -> None:
    """Print the table and write it to `results/third_order.csv`."""
    model, frames = make_model(), np.arange(15.0, END + 1, 15.0)
    start = jnp.full(len(model.space.mesh.nodes), 293.0)
    nodes = np.unique(model.space.mesh.faces)
    fine = uniform_steps(frames, END / 3000, (OFF,))
    exact = run(model, fine, Sdirk2(), 1e-10)[:, nodes]
    rows = []
    for tolerance in TOLERANCES:
        grid = plan_steps(
            model, start, frames, tolerance=tolerance, largest=END / 4, switches=(OFF,)
        )
        for scheme in (Sdirk2(), Sdirk3()):
            error = float(jnp.abs(run(model, grid, scheme, 1e-8)[:, nodes] - exact).max())
            solves = scheme.solves() * len(grid.size)
            rows.append((scheme.order(), tolerance, len(grid.size), solves, f"{error:.3g}"))
            print(f"order {scheme.order()}: {len(grid.size)} steps, {solves} solves, {error:.2e} K")
    with (HERE / "results" / "third_order.csv").open("w", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(("order", "tolerance_K", "steps", "solves", "error_K"))
        table.writerows(rows)


if __name__ == "__main__":
    main()
