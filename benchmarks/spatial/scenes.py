"""Two objects whose conductivity varies: a plate, smoothly, and a rod made of three patches.

    python benchmarks/spatial/scenes.py FOLDER

writes FOLDER/plate and FOLDER/rod, each a scene with three runs to fit and one held out, with
white noise, a fixed pattern and quiet frames as a camera has them. Made by `truth.py` on meshes of
its own; `study.py` fits them.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import skfem
import trimesh
from truth import Body, Law, run

from thermo.mesh import cylinder_mesh
from thermo.observe import Heater, Recording, Run, Scene, StatedMaterial, write_scene

START, WHITE, PATTERN = 295.15, 0.05, 0.03
QUIET_FRAMES, SAMPLES, STEP, END, EVERY = 25, 400, 0.1, 60.0, 2
DENSITY, HEAT_CAPACITY, CONVECTION, EMISSIVITY = 1200.0, 1500.0, 8.0, 0.9


@dataclass(frozen=True)
class Thing:
    """An object: its linear mesh [m], its conductivity, and where lamps of 3 W shine on it."""

    name: str
    mesh: skfem.MeshTet
    law: Law
    lamps: dict[str, tuple[np.ndarray, np.ndarray]]


def smooth(place: np.ndarray) -> np.ndarray:
    """From 0.4 to 1.6 W/m/K over the plate, in both directions [m]."""
    x, y = place[0], place[1]
    return 0.8 * np.exp(0.6 * np.sin(np.pi * x / 0.06) + 0.3 * np.cos(2 * np.pi * y / 0.04))


def patchy(place: np.ndarray) -> np.ndarray:
    """0.5, 1.5 and 0.8 W/m/K in three parts of the rod's length [m]."""
    z = place[2]
    return np.where(z < -0.01, 0.5, np.where(z < 0.012, 1.5, 0.8))


def plate() -> Thing:
    """60 by 40 by 8 mm."""
    axes = (np.linspace(-0.03, 0.03, 31), np.linspace(-0.02, 0.02, 21), np.linspace(0, 0.008, 7))
    down = np.array([0.0, 0.0, -1.0])
    lamps = {
        "left": (np.array([-0.015, 0.005, 0.02]), down),
        "right": (np.array([0.015, -0.005, 0.02]), down),
        "test_heating": (np.array([0.0, 0.0, 0.02]), down),
    }
    return Thing("plate", skfem.MeshTet.init_tensor(*axes), smooth, lamps)


def rod() -> Thing:
    """16 mm thick, 60 mm long."""
    body = cylinder_mesh(0.008, 0.06, 5, 60)
    nodes = body.nodes - [0, 0, body.nodes[:, 2].mean()]
    side, low = np.array([-1.0, 0.0, 0.0]), np.array([0.0, -1.0, 0.0])
    lamps = {
        "left": (np.array([0.02, 0.0, -0.012]), side),
        "right": (np.array([0.0, 0.02, 0.014]), low),
        "test_heating": (np.array([0.02, 0.0, 0.001]), side),
    }
    mesh = skfem.MeshTet(np.ascontiguousarray(nodes.T), np.ascontiguousarray(body.cells.T))
    return Thing("rod", mesh, patchy, lamps)


def _samples(thing: Thing, random: np.random.Generator) -> tuple[np.ndarray, trimesh.Trimesh]:
    """Points on the surface [m], and the surface."""
    facets = thing.mesh.facets[:, thing.mesh.boundary_facets()].T
    surface = trimesh.Trimesh(thing.mesh.p.T, facets, process=True)
    surface.fix_normals()
    points, _ = trimesh.sample.sample_surface_even(
        surface, SAMPLES, seed=int(random.integers(2**31))
    )
    return np.asarray(points), surface


def make(thing: Thing, folder: Path, seed: int = 0) -> None:
    """Simulate all runs of an object and write its scene."""
    random = np.random.default_rng(seed)
    points, surface = _samples(thing, random)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "surface.ply"
    surface.export(path)
    body = Body(thing.mesh, thing.law, DENSITY * HEAT_CAPACITY, CONVECTION, EMISSIVITY)
    # A hair inside, so that every point finds its cell.
    probe = body.basis.probes((points * (1 - 1e-6) + points.mean(0) * 1e-6).T)
    pattern = PATTERN * random.standard_normal(len(points))
    runs = {}
    for name in ("cooling", *thing.lamps):
        heater, heat, until, around = None, np.zeros(body.mass.shape[0]), 0.0, 273.15
        if name in thing.lamps:
            centre, direction = thing.lamps[name]
            heater = Heater(centre, direction, 0.008, 3.0, 30.0)
            heat, until, around = 3.0 * body.lamp(centre, direction, 0.008), 30.0, START
        time, nodal = run(body, START, around, heat, until, END, STEP)
        clean = nodal[::EVERY] @ probe.T
        noise = WHITE * random.standard_normal(clean.shape) + pattern
        quiet = START + WHITE * random.standard_normal((QUIET_FRAMES, len(points))) + pattern
        record = Recording(points, time[::EVERY], clean + noise, quiet=quiet)
        runs[name] = Run(
            name, record, START, around, around, heater=heater, held_out=name == "test_heating"
        )
        print(f"{thing.name} {name}: {len(nodal[0])} nodes, to {clean.max():.1f} K", flush=True)
    material = StatedMaterial("made up", DENSITY, HEAT_CAPACITY, None)
    scene = Scene(
        folder, thing.name, path, "m", material, CONVECTION, EMISSIVITY, ("conductivity",), {}, runs
    )
    write_scene(folder, scene)


def main() -> None:
    """Make both."""
    if len(sys.argv) != 2:
        sys.exit("which folder? python benchmarks/spatial/scenes.py FOLDER")
    for thing in (plate(), rod()):
        make(thing, Path(sys.argv[1]) / thing.name)


if __name__ == "__main__":
    main()
