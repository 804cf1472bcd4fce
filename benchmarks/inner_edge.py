"""A lamp on the foot of a rib: what cells make wrong about an inner edge, by how small they are.

    python benchmarks/inner_edge.py

A base of 50 x 30 x 8 mm with a rib of 8 x 12 mm along it is heated by a spot that lights the rib's
top and the base beside it. `thermo.simulate` at several `cells_per_depth` is compared with
scikit-fem in quadratic functions on structured cells that grow from 0.35 mm at the foot, by
TR-BDF2. Writes benchmarks/results/inner_edge.csv: differences [K] of all readings, of those within
3 mm of the foot and of the others, and what the last cut of the reference's cells changed.
"""

from __future__ import annotations

import csv
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from hidden._bodies import Body, body_of
from hidden._heat import COLD, Lamp, Physics, simulate
from scipy.sparse import csr_array
from skfem import Basis, ElementTetP2, MeshTet

import thermo
from thermo.inverse import Meshing
from thermo.observe import Heater, Recording, Run, StatedMaterial

RESULTS = Path(__file__).parent / "results" / "inner_edge.csv"
COLUMNS = ("cells_per_depth", "nodes", "rms [K]", "most [K]", "rms at the foot", "rms elsewhere")
LAMP: Final = Lamp((0.018, 0.012, 0.06), (0.0, 0.0, -1.0), 0.011, 6.0, 60.0, 1e-6)
STATED: Final = Physics(2200.0, 850.0, 3.0, 9.0, 0.9)
END, NEAR = 100.0, 0.003  # s, m
FINENESS = (1.0, 4.0, 8.0)


def block(along: int) -> MeshTet:
    """The structured cells, with `along` lines over the length."""
    away = np.array([0.0, 0.35, 1.0, 2.2, 4.4, 7.5])

    def to(end: float) -> np.ndarray:
        return np.append(away[away < 0.85 * end], end)

    across = np.concatenate([11 - to(11.0), 11 + away[:4], [15.0], 19 - away[:4], 19 + to(11.0)])
    upright = np.concatenate([8 - to(8.0), 8 + to(12.0)])
    lines = (np.linspace(0, 50, along), *(np.unique(one.round(6)) for one in (across, upright)))
    mesh = MeshTet.init_tensor(*(1e-3 * one for one in lines))
    _, y, z = mesh.p[:, mesh.t].mean(1)
    return mesh.restrict(np.flatnonzero((z < 0.008) | ((y > 0.011) & (y < 0.019))))


def read_at(body: Body, points: np.ndarray, inside: np.ndarray) -> Body:
    """The body with other points on its skin [m], and others a hair below them."""
    basis = Basis(body.mesh, ElementTetP2(), intorder=4)
    return replace(body, reading=csr_array(basis.probes(inside.T)), points=points)


def main() -> None:
    """Print the table and write it."""
    body = body_of(block(13), 400, 0)
    foot = np.minimum(
        *(np.hypot(body.points[:, 1] - y, body.points[:, 2] - 0.008) for y in (0.011, 0.019))
    )
    # Not on the edge itself, where the temperature bends without bound.
    body = read_at(body, points := body.points[foot > 0.001], _below(points))
    foot = foot[foot > 0.001]
    steps, coarse = simulate(body, STATED, LAMP, COLD, END)
    # A frame a second: sooner after a switch heat has not gone as deep as a cell is wide.
    frames = np.isclose(steps, steps.round())
    time = steps[frames]
    cut = body_of(block(21), 10, 0)
    _, fine = simulate(read_at(cut, points, _below(points)), STATED, LAMP, COLD, END)
    wanted = fine[frames]
    made = measured(coarse[frames] - wanted, foot)
    rows = [["the reference's last cut", cut.skin.shape[1], *made]]
    print(*COLUMNS, sep=", ")
    print(*rows[0], sep=", ", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        scene = the_scene(Path(folder), body, points, time)
        for fineness in FINENESS:
            meshing = Meshing(max_nodes=100_000, cells_per_depth=fineness)
            found = thermo.simulate(scene, "lamp", meshing=meshing)
            at = np.searchsorted(found.time, time - 1e-9)
            apart = found.temperature[at] - wanted
            rows.append([fineness, len(found.mesh.nodes), *measured(apart, foot)])
            print(*rows[-1], sep=", ", flush=True)
    with RESULTS.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])


def _below(points: np.ndarray) -> np.ndarray:
    """Points [m] a hair inside the block."""
    x, y, z = points.T
    inside = np.array(points)
    rib = (y > 0.011 - 1e-9) & (y < 0.019 + 1e-9)
    sides = [
        (x < 1e-9, 0, 1), (x > 0.05 - 1e-9, 0, -1), (y < 1e-9, 1, 1), (y > 0.03 - 1e-9, 1, -1),
        (z < 1e-9, 2, 1), (z > 0.02 - 1e-9, 2, -1), ((np.abs(z - 0.008) < 1e-9) & ~rib, 2, -1),
        ((np.abs(y - 0.011) < 1e-9) & (z > 0.008), 1, 1),
        ((np.abs(y - 0.019) < 1e-9) & (z > 0.008), 1, -1),
    ]  # fmt: skip
    for there, axis, way in sides:
        inside[there, axis] += way * 1e-8
    return inside


def the_scene(folder: Path, body: Body, points: np.ndarray, time: np.ndarray) -> thermo.Scene:
    """The same for ThermoField, its recording a blank [K]."""
    body.surface.export(folder / "block.stl")
    blank = Recording(points, time, np.full((len(time), len(points)), COLD))
    lamp = Heater(LAMP.centre, LAMP.direction, LAMP.radius, LAMP.power, LAMP.until)
    run = Run(
        "lamp", blank, initial_temperature=COLD, ambient_temperature=COLD,
        radiation_temperature=COLD, heater=lamp,
    )  # fmt: skip
    material = StatedMaterial(
        "some", density=STATED.density, heat_capacity=STATED.capacity,
        conductivity=STATED.conductivity,
    )  # fmt: skip
    return thermo.Scene(
        folder=folder, object="block", surface_path=folder / "block.stl", unit="m",
        material=material, convection=STATED.convection, emissivity=STATED.emissivity,
        unknown=("conductivity",), prior={}, runs={"lamp": run},
    )  # fmt: skip


def measured(apart: np.ndarray, foot: np.ndarray) -> list[str]:
    """Of differences [K] at distances [m] from the foot, what the columns say."""
    parts = (apart, apart[:, foot < NEAR], apart[:, foot >= NEAR])
    rms = [float(np.sqrt((one**2).mean())) for one in parts]
    return [f"{one:.3g}" for one in (rms[0], np.abs(apart).max(), *rms[1:])]


if __name__ == "__main__":
    main()
