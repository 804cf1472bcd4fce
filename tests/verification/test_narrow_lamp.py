"""A spot much narrower than cells of the skin would be, against its closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from one_mesh import simulate_once
from scipy.special import erf, j0

import thermo
from thermo.inverse import Meshing
from thermo.observe import Heater, Recording, Run, Scene, StatedMaterial

SIDE, SPOT, POWER = 0.04, 1e-3, 0.5  # m, m, W
CONDUCTIVITY, CAPACITY = 1.0, 2e6  # W/m/K, J/m3/K


def rise(away: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Rise [K] of a half-space (times, places) under a Gaussian spot that is lit at time zero.

    P / (2 pi k) int_0^inf J0(l r) exp(-l^2 s^2 / 2) erf(l sqrt(a t)) dl; Carslaw and Jaeger,
    Conduction of Heat in Solids, second edition, section 10.5, summed over the discs of the spot.
    """
    wave = np.linspace(1e-6, 8 / SPOT, 8001)
    spot = np.exp(-0.5 * (wave * SPOT) ** 2) * j0(np.multiply.outer(away, wave))
    depth = np.sqrt(CONDUCTIVITY / CAPACITY * time)
    shares = spot[None] * erf(np.multiply.outer(depth, wave))[:, None]
    return POWER / (2 * np.pi * CONDUCTIVITY) * np.trapezoid(shares, wave, axis=2)


def test_a_narrow_spot_is_met_to_a_fiftieth_of_its_rise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The closed form tells how good the mesh is: no coarser one is asked.
    simulate_once(monkeypatch)
    body = trimesh.creation.box([SIDE] * 3)
    body.export(tmp_path / "block.ply")
    away = SPOT * np.array([0.0, 0.5, 1.0, 2.0, 4.0])
    places = np.stack([0.8 * away, 0.6 * away, np.full(len(away), SIDE / 2)], axis=1)
    time = np.arange(0.0, 31.0, 3.0)
    run = Run(
        name="spot", recording=Recording(places, time, np.full((len(time), len(away)), 300.0)),
        initial_temperature=300.0, ambient_temperature=300.0, radiation_temperature=300.0,
        heater=Heater([0.0, 0.0, 0.1], [0.0, 0.0, -1.0], SPOT, POWER, 100.0),
    )  # fmt: skip
    scene = Scene(
        folder=tmp_path, object="block", surface_path=tmp_path / "block.ply", unit="m",
        material=StatedMaterial("clay", 2000.0, CAPACITY / 2000.0, CONDUCTIVITY), convection=0.0,
        emissivity=0.0, unknown=(), prior={}, runs={"spot": run},
    )  # fmt: skip
    found = thermo.simulate(scene, run="spot", meshing=Meshing(max_nodes=5000))
    exact = rise(away, time)
    # The mesher does not repeat itself. With the cells of the skin alone 15 to 38 K are left.
    assert np.abs(found.temperature - 300.0 - exact).max() < 0.02 * exact.max()
