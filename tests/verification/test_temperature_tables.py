"""Properties stated at some temperatures: a steady slab, stored heat, and data of another code."""

from __future__ import annotations

from pathlib import Path

import equinox as eqx
import numpy as np
import pytest
import trimesh
from bricks import lay_bricks
from one_mesh import simulate_once
from scipy.integrate import solve_ivp

from thermo.inverse import Meshing, Uniform, invert, load_estimate, save_estimate, simulate
from thermo.observe import (
    Box,
    Heater,
    Prescribed,
    Recording,
    Run,
    Scene,
    StatedMaterial,
    TemperatureTable,
    read_scene,
    write_scene,
)

SIDE, HEIGHT = 0.004, 0.008  # m
AIR, DENSITY, CONDUCTIVITY = 300.0, 1200.0, 0.5
CAPACITY = TemperatureTable((280.0, 340.0, 360.0), (1000.0, 1600.0, 1500.0))
POWER, LIT = 0.1, 40.0  # W, s
TIME = np.linspace(0.0, 60.0, 31)
EVERYWHERE = Box([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0])
LAMP = Heater([0.0, 0.0, 1.0], [0.0, 0.0, -1.0], 1.0, POWER, LIT, 0.0)
MESHING = Meshing(max_nodes=500)


@pytest.fixture(autouse=True)
def once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Closed forms tell how good a mesh is: no coarser one is asked."""
    simulate_once(monkeypatch)


def column(folder: Path, material: StatedMaterial, run: Run) -> Scene:
    """A column that exchanges nothing through its sides, as read back from its folder."""
    folder.mkdir(parents=True, exist_ok=True)
    body = trimesh.creation.box([SIDE, SIDE, HEIGHT])
    body.apply_translation([0.0, 0.0, HEIGHT / 2])
    body.export(folder / "column.ply")
    scene = Scene(
        folder, "column", folder / "column.ply", "m", material, 0.0, 0.0, ("conductivity",), {},
        {run.name: run},
    )  # fmt: skip
    write_scene(folder / "scene", scene)
    return read_scene(folder / "scene")


def heated(read: np.ndarray) -> Run:
    """What was read below while the lamp shone on the top, and after that."""
    recording = Recording(np.zeros((1, 3)), TIME, read[:, None])
    return Run("lamp", recording, AIR, AIR, AIR, LAMP, insulated=(EVERYWHERE,))


def volumes(count: int = 400) -> np.ndarray:
    """Temperatures [K] below the column by finite volumes of another code."""
    size = HEIGHT / count

    def rate(time: float, now: np.ndarray) -> np.ndarray:
        flow = np.zeros(count + 1)
        flow[1:-1] = CONDUCTIVITY * np.diff(now) / size
        flow[-1] = POWER / SIDE**2 if time < LIT else 0.0
        capacity = np.interp(now, CAPACITY.temperature, CAPACITY.value)
        return np.diff(flow) / size / (DENSITY * capacity)

    lower, now = [], np.full(count, AIR)
    for begin, end in ((0.0, LIT), (LIT, TIME[-1])):
        at = TIME[(TIME >= begin) & (TIME <= end)]
        found = solve_ivp(
            rate, (begin, end - 1e-9), now, "LSODA", np.minimum(at, end - 1e-9),
            rtol=1e-8, atol=1e-8, lband=1, uband=1,
        )  # fmt: skip
        lower.append(found.y[0] if not lower else found.y[0, 1:])
        now = found.y[:, -1]
    return np.concatenate(lower)


def test_heat_that_goes_in_is_stored(tmp_path: Path) -> None:
    material = StatedMaterial("clay", DENSITY, CAPACITY, 400.0)
    scene = column(tmp_path, material, heated(np.full(len(TIME), AIR)))
    end = float(simulate(scene, "lamp", meshing=MESHING).temperature[-1, 0])
    at = np.linspace(AIR, end, 10001)
    stored = np.trapezoid(np.interp(at, CAPACITY.temperature, CAPACITY.value), at)
    assert end > 315.0
    assert DENSITY * SIDE**2 * HEIGHT * stored == pytest.approx(POWER * LIT, rel=1e-4)


def test_a_steady_slab_whose_conductivity_grows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The mesher does not repeat itself, and misses by more at the steep end now and then.
    lay_bricks(monkeypatch, (2, 2, 24), (-SIDE / 2, -SIDE / 2, 0.0), (SIDE, SIDE, HEIGHT))
    table = TemperatureTable((290.0, 350.0, 400.0), (0.2, 0.5, 0.3))
    recorded = np.linspace(0.001, 0.007, 7)
    points = np.stack([np.full(7, SIDE / 2), np.zeros(7), recorded], 1)
    held = [
        Prescribed([-1.0, -1.0, z - 1e-6], [1.0, 1.0, z + 1e-6], [0.0, 3e3], [level, level])
        for z, level in ((0.0, 300.0), (HEIGHT, 400.0))
    ]
    frames = np.array([0.0, 3e3])
    run = Run(
        "steady", Recording(points, frames, np.full((2, 7), AIR)), AIR, AIR, AIR,
        prescribed=tuple(held), insulated=(EVERYWHERE,),
    )  # fmt: skip
    scene = column(tmp_path, StatedMaterial("clay", DENSITY, 1000.0, table), run)
    # Steps on the way do not matter to the steady end.
    found = simulate(scene, "steady", meshing=MESHING, tolerance=0.02).temperature[-1]
    # Kirchhoff: the integral of k over temperature is linear along the slab.
    levels = np.linspace(300.0, 400.0, 100001)
    conducted = np.append(0.0, np.cumsum(np.interp(levels[:-1] + 5e-4, *_columns(table))))
    wanted = np.interp(recorded / HEIGHT * conducted[-1], conducted, levels)
    np.testing.assert_allclose(found, wanted, atol=0.1)
    assert abs(wanted - (300.0 + 100.0 * recorded / HEIGHT)).max() > 4.0, "far from a straight line"


def _columns(table: TemperatureTable) -> tuple[tuple[float, ...], tuple[float, ...]]:
    return table.temperature, table.value


def test_a_conductivity_is_found_beside_a_capacity_that_is_stated(tmp_path: Path) -> None:
    material = StatedMaterial("clay", DENSITY, CAPACITY, 0.3)
    scene = column(tmp_path, material, heated(volumes()))
    found = invert(scene, choice=Uniform(), meshing=Meshing(max_nodes=300, corrected=False))
    assert found.fields["conductivity"].cells[0] == pytest.approx(CONDUCTIVITY, rel=0.005)
    assert found.runs["lamp"].rmse < 0.03
    # An estimate carries the table along.
    save_estimate(tmp_path / "estimate.npz", found)
    _, _, stated, _ = load_estimate(tmp_path / "estimate.npz")
    assert stated.conductivity_law is None and eqx.tree_equal(stated, found.stated)
