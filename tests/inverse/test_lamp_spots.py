"""Cells under a lamp are as short as its spot is narrow, and no shorter than it needs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from thermo.inverse._body import Meshing, sizing_of, surface_of
from thermo.observe import Heater, Scene

DIFFUSIVITY = 5e-7  # m2/s


def lit(scene: Scene, *lamps: Heater | None) -> Scene:
    run = scene.runs["lamp"]
    return replace(scene, runs={f"{n}": replace(run, heater=one) for n, one in enumerate(lamps)})


def lamp(radius: float, aside: float = 0.0) -> Heater:
    return Heater([0.01 + aside, 0.01, 0.1], [0.0, 0.0, -1.0], radius, 1.0, 60.0)


def test_a_wide_lamp_and_none_change_no_cell(scene: Scene) -> None:
    surface = surface_of(scene)
    for one in (None, lamp(0.05)):
        assert sizing_of(lit(scene, one), surface, DIFFUSIVITY, Meshing()).fine == ()


def test_a_narrow_spot_is_fine_once_for_all_runs_that_it_lights(scene: Scene) -> None:
    surface = surface_of(scene)
    runs = lit(scene, lamp(5e-4), lamp(5e-4), None)
    (spot,) = sizing_of(runs, surface, DIFFUSIVITY, Meshing()).fine
    assert spot.edge == pytest.approx(0.5 * 5e-4)
    away = np.linalg.norm(spot.points[:, :2] - 0.01, axis=1)
    assert away.max() == pytest.approx(1e-3) and np.ptp(spot.points[:, 2]) == pytest.approx(0.0)


def test_many_spots_are_less_fine_than_one_where_nodes_are_few(scene: Scene) -> None:
    surface = surface_of(scene)
    runs = lit(scene, *(lamp(5e-4, 1e-3 * number) for number in range(5)))
    edges = [
        [one.edge for one in sizing_of(runs, surface, DIFFUSIVITY, Meshing(max_nodes=most)).fine]
        for most in (100_000, 4000)
    ]
    assert len(edges[0]) == len(edges[1]) == 5
    assert edges[0] == pytest.approx([2.5e-4] * 5) and edges[1][0] == pytest.approx(
        2.5e-4 * 5 ** (1 / 3)
    )


def test_a_spot_beside_the_body_is_nowhere(scene: Scene) -> None:
    surface = surface_of(scene)
    beside = lit(scene, lamp(5e-4, aside=0.05))
    assert sizing_of(beside, surface, DIFFUSIVITY, Meshing()).fine == ()
