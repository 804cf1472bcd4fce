"""A run's conditions on a mesh: lamp, prescribed boxes, switches, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.inverse._conditions import Conditions, conditions, make_model
from thermo.inverse._properties import Stated, properties
from thermo.mesh import face_areas
from thermo.observe import Air, Box, Course, Heater, Prescribed, Run, Scene
from thermo.physics import assemble, discretise, heat_rate
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


def test_insulated_faces_lose_nothing_and_the_lamp_heats_them_all_the_same(scene: Scene) -> None:
    away = Box([-1.0] * 3, [2.0] * 3)
    cooling, lamp = scene.runs["cooling"], scene.runs["lamp"]
    height = float(MESH.nodes[:, 2].max())
    top = Box([-1.0, -1.0, height], [2.0, 2.0, height])
    under = conditions(replace(cooling, insulated=(top,)), SPACE)
    up = MESH.normals[:, 2] > 0.5
    assert np.array_equal(np.asarray(under.exposed), np.where(up, 0.0, 1.0))
    body = properties(Stated(0.8, 1.54e6, 25.0, 0.6), {}, len(MESH.cells), len(MESH.faces))

    def taken(under: Conditions) -> float:
        model = make_model(SPACE, body, under)
        hot = under.start(len(SPACE.mesh.nodes))
        return float(np.asarray(heat_rate(assemble(model), hot, 0.0)).sum())

    areas = face_areas(MESH)
    share = areas[~up].sum() / areas.sum()
    assert taken(under) == pytest.approx(share * taken(conditions(cooling, SPACE)), rel=1e-9)
    assert taken(conditions(replace(cooling, insulated=(away,)), SPACE)) == 0.0
    assert taken(conditions(replace(lamp, insulated=(away,)), SPACE)) == pytest.approx(1.2)


def test_an_insulated_box_away_from_the_surface_is_refused(scene: Scene) -> None:
    run = replace(scene.runs["cooling"], insulated=(Box([5.0, 0.0, 0.0], [6.0, 1.0, 1.0]),))
    with pytest.raises(InputError, match="no face has its centre") as caught:
        conditions(run, SPACE)
    assert caught.value.where == "runs.cooling.insulated[0]" and "5.0" in str(caught.value.value)


def test_air_that_is_known_takes_the_place_of_the_bodys_convection(scene: Scene) -> None:
    run = scene.runs["cooling"]
    height = float(MESH.nodes[:, 2].max())
    top = ([-1.0, -1.0, height], [2.0, 2.0, height])
    still = Air(Box(*top), 4.0, run.ambient_temperature)
    warm = Air(Box(*top), 4.0, run.ambient_temperature + 30.0)
    up = np.asarray(MESH.normals[:, 2] > 0.5)
    body = properties(Stated(0.8, 1.54e6, 25.0, 0.0), {}, len(MESH.cells), len(MESH.faces))
    areas = face_areas(MESH)

    def taken(**changes: Any) -> float:
        under = conditions(replace(run, **changes), SPACE)
        hot = under.start(len(SPACE.mesh.nodes))
        return float(
            np.asarray(heat_rate(assemble(make_model(SPACE, body, under)), hot, 0.0)).sum()
        )

    apart = run.ambient_temperature - run.initial_temperature
    sides, lid = 25.0 * apart * areas[~up].sum(), 4.0 * areas[up].sum()
    assert taken(air=(still,)) == pytest.approx(sides + lid * apart, rel=1e-9)
    # Each has its own temperature; of two in one place the later counts, behind insulation neither.
    assert taken(air=(still, warm)) == pytest.approx(sides + lid * (apart + 30.0), rel=1e-9)
    assert taken(air=(warm,), insulated=(Box(*top),)) == pytest.approx(sides, rel=1e-9)


def test_air_away_from_the_surface_is_refused(scene: Scene) -> None:
    air = Air(Box([5.0, 0.0, 0.0], [6.0, 1.0, 1.0]), 4.0, 300.0)
    with pytest.raises(InputError, match="no face has its centre") as caught:
        conditions(replace(scene.runs["cooling"], air=(air,)), SPACE)
    assert caught.value.where == "runs.cooling.air[0].box" and "5.0" in str(caught.value.value)


def test_a_course_scales_the_lamp_between_its_switches(scene: Scene) -> None:
    lamp = scene.runs["lamp"]
    logged = heater(lamp.heater, course=Course([0.0, 10.0, 12.0], [0.5, 1.0, 0.9]))
    schedule = conditions(replace(lamp, heater=logged), SPACE).schedule
    found = [float(schedule.share(time)) for time in (-0.1, 0.0, 5.0, 10.0, 11.0, 15.0, 19.0)]
    assert found == pytest.approx([0.0, 0.5, 0.75, 1.0, 0.95, 0.9, 0.0])
    slow = conditions(replace(lamp, heater=heater(logged, rise=3.0, course=logged.course)), SPACE)
    assert float(slow.schedule.share(5.0)) == pytest.approx(0.75 * (1 - np.exp(-5.0 / 3.0)))
