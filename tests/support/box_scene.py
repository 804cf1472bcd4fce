"""A small block under a lamp and cooling down, with temperatures that scikit-fem made."""

from __future__ import annotations

import functools
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse.linalg as sla
import skfem
import trimesh
from skfem.models.poisson import laplace, mass, unit_load

SIZE = np.array([0.020, 0.012, 0.008])  # m
DENSITY, HEAT_CAPACITY = 1100.0, 1400.0
CONDUCTIVITY, CONVECTION, EMISSIVITY = 0.8, 25.0, 0.6
AIR, HOT = 295.0, 335.0  # K
FRAMES = np.linspace(0.0, 30.0, 21)  # s
NOISE = 0.01  # K
BOLTZMANN = 5.670374419e-8

LAMPS: dict[str, dict[str, Any]] = {
    "lamp": {"centre": [0.013, 0.006, 0.02], "power": 1.2, "until": 18.0},
    "test_lamp": {"centre": [0.006, 0.007, 0.02], "power": 1.0, "until": 12.0},
}
RADIUS = 0.007  # m


@dataclass(frozen=True)
class Start:
    """Temperature [K] at the beginning and the lamp over one run."""

    initial: float
    lamp: dict[str, Any] | None


RUNS = {
    "lamp": Start(AIR, LAMPS["lamp"]),
    "cooling": Start(HOT, None),
    "test_lamp": Start(AIR, LAMPS["test_lamp"]),
}


def sample_points() -> np.ndarray:
    """Thirty points [m] on the top and on three sides of the block."""
    x, y = np.meshgrid([0.002, 0.006, 0.010, 0.014, 0.018], [0.002, 0.005, 0.0075, 0.0105])
    top = np.stack([x.ravel(), y.ravel(), np.full(x.size, SIZE[2])], axis=1)
    x, z = np.meshgrid([0.004, 0.010, 0.016], [0.0025, 0.006])
    side = np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1)
    ends = np.array(
        [[0.0, 0.004, 0.005], [0.0, 0.008, 0.003], [0.02, 0.004, 0.003], [0.02, 0.008, 0.005]]
    )
    return np.concatenate([top, side, ends])


def _simulate(start: Start, radiates: bool, step: float = 0.25) -> np.ndarray:
    """Temperatures [K] (frames, samples) on a structured mesh of TET10 cells.

    The scheme is the two-stage L-stable SDIRK with g = 1 - 1/sqrt(2). Radiation to surroundings
    at the air's temperature is iterated in each stage, all else is linear.
    """
    axes = [np.linspace(0, size, n + 1) for size, n in zip(SIZE, (8, 5, 6), strict=True)]
    mesh = skfem.MeshTet.init_tensor(*axes)
    basis = skfem.Basis(mesh, skfem.ElementTetP2())
    skin = skfem.FacetBasis(mesh, skfem.ElementTetP2(), intorder=6)
    capacity = DENSITY * HEAT_CAPACITY * mass.assemble(basis)
    loss = CONVECTION * mass.assemble(skin)
    stiffness = CONDUCTIVITY * laplace.assemble(basis) + loss
    air = CONVECTION * AIR * unit_load.assemble(skin)
    lamp = np.zeros(basis.N)
    if start.lamp is not None:
        centre = start.lamp["centre"]

        @skfem.LinearForm
        def spot(v: Any, w: Any) -> Any:
            square = (w.x[0] - centre[0]) ** 2 + (w.x[1] - centre[1]) ** 2
            return np.exp(-square / (2 * RADIUS**2)) * (w.n[2] > 0.5) * v

        lamp = spot.assemble(skin)
        lamp *= start.lamp["power"] / lamp.sum()  # shape functions sum to one

    @skfem.LinearForm
    def radiation(v: Any, w: Any) -> Any:
        return EMISSIVITY * BOLTZMANN * (AIR**4 - w["temperature"] ** 4) * v

    def source(temperature: np.ndarray, time: float) -> np.ndarray:
        total = air + (lamp if start.lamp and time < start.lamp["until"] else 0.0)
        if radiates:
            total = total + radiation.assemble(skin, temperature=skin.interpolate(temperature))
        return total

    g = 1 - 1 / np.sqrt(2)
    solve = sla.factorized((capacity + g * step * stiffness).tocsc())

    def slope(base: np.ndarray, guess: np.ndarray, time: float) -> np.ndarray:
        rate = np.zeros_like(base)
        for _ in range(3 if radiates else 1):
            rate = solve(source(guess, time) - stiffness @ base)
            guess = base + g * step * rate
        return rate

    probe = basis.probes(sample_points().T)
    now = np.full(basis.N, start.initial)
    frames = [probe @ now]
    each = round((FRAMES[1] - FRAMES[0]) / step)
    for number in range(each * (len(FRAMES) - 1)):
        time = number * step
        first = slope(now, now, time + g * step)
        # The last stage lies at the end of the step: just before a switch, not after it.
        second = slope(now + (1 - g) * step * first, now + step * first, time + step - 1e-9)
        now = now + step * ((1 - g) * first + g * second)
        if (number + 1) % each == 0:
            frames.append(probe @ now)
    return np.array(frames)


@functools.cache
def temperatures(radiates: bool = False) -> dict[str, np.ndarray]:
    """Noise-free temperatures [K] (frames, samples) of every run."""
    return {name: _simulate(start, radiates) for name, start in RUNS.items()}


def scene_table(radiates: bool = False) -> dict[str, Any]:
    """`scene.json` of the block; what is stated is true, with a conductivity to be found."""
    runs = {}
    for name, start in RUNS.items():
        heater = None
        if start.lamp is not None:
            heater = {"kind": "spot", "direction": [0, 0, -1], "radius": RADIUS, **start.lamp}
        runs[name] = {
            "recording": f"{name}.npz",
            "initial_temperature": start.initial,
            "ambient_temperature": AIR,
            "radiation_temperature": AIR,
            "heater": heater,
            "held_out": name.startswith("test"),
        }
    return {
        "format": "thermofield-scene/1",
        "object": "block",
        "surface": "block.ply",
        "unit": "mm",
        "material": {
            "name": "epoxy",
            "density": DENSITY,
            "heat_capacity": HEAT_CAPACITY,
            "conductivity": CONDUCTIVITY,
        },
        "surface_exchange": {
            "convection": CONVECTION,
            "emissivity": EMISSIVITY if radiates else 0.0,
        },
        "unknown": ["conductivity"],
        "runs": runs,
        "truth": {"conductivity": CONDUCTIVITY},
    }


def write_block(folder: Path, *, radiates: bool = False) -> Path:
    """Write the block as a scene folder; with noise, quiet frames and some missing values."""
    folder.mkdir(parents=True, exist_ok=True)
    body = trimesh.creation.box(extents=SIZE * 1e3)
    body.apply_translation(SIZE * 500)
    body.subdivide().export(folder / "block.ply")
    generator = np.random.default_rng(3)
    points = sample_points()
    for name, clean in temperatures(radiates).items():
        data = clean + generator.normal(0, NOISE, clean.shape)
        data[5, 3], data[11:13, 7] = np.nan, np.nan
        quiet = RUNS[name].initial + generator.normal(0, NOISE, (12, len(points)))
        np.savez(
            folder / f"{name}.npz", allow_pickle=False,
            points=points, time=FRAMES, temperature=data, quiet=quiet,
        )  # fmt: skip
    (folder / "scene.json").write_text(json.dumps(scene_table(radiates)))
    return folder


def edit(folder: Path, **changes: Any) -> Path:
    """Set top-level entries of a folder's `scene.json`."""
    table = json.loads((folder / "scene.json").read_text())
    (folder / "scene.json").write_text(json.dumps({**table, **changes}))
    return folder
