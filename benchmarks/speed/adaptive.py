"""A minute of heating of the bunny to 10 mK: planned steps of ours beside 600 of the SciPy loop.

    python adaptive.py --data FOLDER [--tolerance K]

FOLDER holds `scenes/bunny`. Both run on one mesh of linear cells with the true conductivity; the
reference is ours with 3000 even steps of second order and a solver tolerance of 1e-9. Prints two
lines of JSON: cost, and the largest error at any frame and surface node.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from pathlib import Path

for name in ("NPROC", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import equinox as eqx  # noqa: E402
import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
from problem import CONVECTION, EMISSIVITY, SIZE, Problem  # noqa: E402
from scipy.spatial import KDTree  # noqa: E402
from scipy_loop import Loop  # noqa: E402
from timing import clock, peak_gb  # noqa: E402

from thermo.mesh import read_surface, sizing_from_physics, tetrahedralise  # noqa: E402
from thermo.observe import Heater, read_scene  # noqa: E402
from thermo.physics import (  # noqa: E402
    ConjugateGradient,
    Model,
    ReadOut,
    TimeGrid,
    between_steps,
    discretise,
    every_step,
    plan_steps,
    solve_heat,
    uniform_steps,
)
from thermo.physics.effects import (  # noqa: E402
    Convection,
    Heating,
    Radiation,
    Schedule,
    spot_profile,
)
from thermo.physics.integrators import Sdirk2  # noqa: E402

FINE, NODES = 3000, 12000


def make_model(problem: Problem, lamp: Heater) -> tuple[Model, ReadOut]:
    """The model, and a read-out of its surface nodes."""
    space = discretise(problem.mesh)
    faces, cells = len(space.mesh.faces), len(space.mesh.cells)
    profile = spot_profile(space, centre=lamp.centre, direction=lamp.direction, radius=lamp.radius)
    surface = (
        Convection(jnp.full(faces, CONVECTION), problem.surroundings),
        Radiation(jnp.full(faces, EMISSIVITY), problem.surroundings),
        Heating(lamp.power, jnp.asarray(profile), Schedule(jnp.asarray(float(lamp.until)))),
    )
    capacity = jnp.full(cells, problem.capacity)
    nodes = np.unique(space.mesh.faces)[:, None].astype(np.int32)
    model = Model(space, jnp.asarray(problem.conductivity), capacity, surface)
    return model, ReadOut(nodes, np.ones(nodes.shape))


@eqx.filter_jit
def run(model: Model, start: jax.Array, grid: TimeGrid, readout: ReadOut, rtol: float) -> jax.Array:
    """Surface temperatures [K] at the frames of a grid."""
    return solve_heat(
        model, start, grid, integrator=Sdirk2(), readout=readout,
        solver=ConjugateGradient(rtol=rtol),
    ).temperature  # fmt: skip


def bunny(data: Path) -> tuple[Problem, Heater]:
    """The minute of heating with the true conductivity, and its lamp."""
    scene = read_scene(data / "scenes" / "bunny")
    heating = scene.runs["heating"]
    if heating.heater is None:
        raise SystemExit(f"{scene.folder}: the run `heating` has no heater; name the given bunny")
    capacity = scene.material.volumetric_heat_capacity()
    surface, value = read_surface(scene.surface_path), 0.1997
    sizing = sizing_from_physics(
        surface, diffusivity=value / capacity, duration=60.0, max_nodes=NODES
    )
    mesh = tetrahedralise(surface, sizing)
    known = np.full(len(mesh.cells), value)
    steps = round(float(heating.recording.time[-1]) / SIZE)
    problem = Problem(
        "bunny-heating-adaptive", mesh, capacity, known, known, steps,
        heating.initial_temperature, heating.ambient_temperature, heating.heater,
    )  # fmt: skip
    return problem, heating.heater


def main() -> None:
    """Run both and print what they cost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--tolerance", type=float, default=1e-3, help="of a planned step [K]")
    given = parser.parse_args()
    problem, lamp = bunny(given.data)
    model, readout = make_model(problem, lamp)
    start = jnp.full(len(problem.mesh.nodes), problem.start)
    frames = np.arange(1, problem.steps + 1) * SIZE
    fine = uniform_steps(frames, frames[-1] / FINE, (lamp.until,))
    exact = np.asarray(run(model, start, fine, readout, 1e-9))

    def planned() -> TimeGrid:
        return every_step(
            plan_steps(
                model,
                start,
                frames[-1:],
                tolerance=given.tolerance,
                largest=frames[-1] / 20,
                switches=(lamp.until,),
            )  # fmt: skip
        )

    grid = planned()
    _, planning, _ = clock(planned)
    begun = time.perf_counter()
    jax.block_until_ready(run(model, start, grid, readout, 1e-4))
    first = time.perf_counter() - begun
    ends, cpu, wall = clock(lambda: jax.block_until_ready(run(model, start, grid, readout, 1e-4)))
    found = between_steps(np.asarray(grid.frame_time), np.asarray(ends), frames, (lamp.until,))
    common = {"problem": problem.name, "task": "forward", "nodes": len(problem.mesh.nodes)}
    ours = {
        **common, "who": "thermo", "steps": len(grid.size), "cpu_s": cpu, "wall_s": wall,
        "cpu_ms_per_step": 1e3 * cpu / len(grid.size), "compile_s": first - wall,
        "peak_gb": peak_gb(), "diff_K": float(np.abs(found - exact).max()), "planning_s": planning,
        "rtol": 1e-4,
    }  # fmt: skip
    print(json.dumps(ours))
    loop = Loop(problem)
    ends, cpu, wall = clock(loop.forward, problem.conductivity)
    places = loop.places[np.argsort(loop.place)][loop.nodes]
    nodes = np.asarray(readout.nodes)[:, 0]
    order = KDTree(places).query(np.asarray(model.space.mesh.nodes)[nodes])[1]
    theirs = {
        **common, "who": "scipy", "steps": problem.steps, "cpu_s": cpu, "wall_s": wall,
        "cpu_ms_per_step": 1e3 * cpu / problem.steps, "compile_s": 0.0, "peak_gb": peak_gb(),
        "diff_K": float(np.abs(ends[:, order] - exact).max()), "rtol": loop.rtol,
    }  # fmt: skip
    print(json.dumps(theirs))


if __name__ == "__main__":
    main()
