"""A run's conditions on a mesh: lamp, prescribed boxes, switches, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.inverse._conditions import conditions, make_model
from thermo.inverse._properties import Stated, properties
from thermo.observe import Heater, Prescribed, Run, Scene
from thermo.physics import discretise
from thermo.physics.effects import Convection, Heating, LaggedRadiation, Radiation

from .objectives import MESH

SPACE = discretise(MESH)
END = ([-1e-3, -1e-3, -1e-3], [0.0, 1.0, 1.0])  # m, the face x = 0


def prescribed(run: Run, low: list[float], high: list[float]) -> Run:
    item = Prescribed(
        np.array(low), np.array(high), np.array([0.0, 30.0]), np.array([300.0, 310.0])
    )
    return replace(run, prescribed=(item,))


def test_temperatures_power_and_switches_are_the_runs(scene: Scene) -> None:
    lamp, cooling = scene.runs["lamp"], scene.runs["cooling"]
    under = conditions(lamp, SPACE)
    assert (under.initial, under.ambient, under.surroundings, under.power) == (295, 295, 295, 1.2)
    assert np.all(np.asarray(under.start(4)) == 295)
    assert (lamp.switches(), cooling.switches()) == ((18.0,), ())
    assert float(conditions(cooling, SPACE).power) == 0 and under.prescribed is None
    total = (np.asarray(under.profile) * np.asarray(SPACE.face_weight)).sum()
    assert total == pytest.approx(1.0, rel=1e-9), "the lamp delivers the power that is stated"
    assert np.all(np.asarray(conditions(cooling, SPACE).profile) == 0)


def test_only_faces_towards_the_lamp_are_lit(scene: Scene) -> None:
    profile = np.asarray(conditions(scene.runs["lamp"], SPACE).profile).max(1)
    up = MESH.normals[:, 2] > 0.5
    assert np.all(profile[~up] == 0) and np.all(profile[up] > 0)


def test_prescribed_nodes_are_those_on_the_surface_in_the_box(scene: Scene) -> None:
    under = conditions(prescribed(scene.runs["cooling"], *END), SPACE)
    assert under.prescribed is not None
    held = np.asarray(under.prescribed.patch) >= 0
    assert np.array_equal(held, SPACE.mesh.nodes[:, 0] < 1e-9)
    assert held.sum() == 9


def test_a_box_away_from_the_surface_is_refused(scene: Scene) -> None:
    run = prescribed(scene.runs["cooling"], [5.0, 0.0, 0.0], [6.0, 1.0, 1.0])
    with pytest.raises(InputError, match="no surface node") as caught:
        conditions(run, SPACE)
    assert caught.value.where == "runs.cooling.prescribed[0].box"
    assert "5.0" in str(caught.value.value) and "metres" in caught.value.remedy


def heater(lamp: Any, **changes: Any) -> Heater:
    parts = {
        name: getattr(lamp, name) for name in ("centre", "direction", "radius", "power", "until")
    }
    return Heater(**{**parts, **changes})


def test_a_lamp_that_misses_is_refused(scene: Scene) -> None:
    run = scene.runs["lamp"]
    away = heater(run.heater, direction=np.array([0.0, 0.0, -1.0]), centre=np.array([9.0, 9, 1]))
    with pytest.raises(InputError, match="lamp does not reach") as caught:
        conditions(replace(run, heater=away), SPACE)
    assert caught.value.where == "runs.lamp.heater" and "9.0" in str(caught.value.value)


@pytest.mark.parametrize(("lagged", "kind"), [(False, Radiation), (True, LaggedRadiation)])
def test_the_model_loses_heat_and_takes_in_the_lamp(lagged: bool, kind: type, scene: Scene) -> None:
    under = conditions(scene.runs["lamp"], SPACE)
    body = properties(Stated(0.8, 1.54e6, 25.0, 0.6), {}, len(MESH.cells), len(MESH.faces))
    model = make_model(SPACE, body, under, lagged=lagged)
    assert [type(effect) for effect in model.surface] == [Convection, kind, Heating]
