"""Boxes and lamps that have nothing to do with the surface are refused, before it is meshed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.inverse import simulate
from thermo.inverse._body import surface_of
from thermo.inverse._stated_places import check_places
from thermo.mesh import Surface
from thermo.observe import Air, Box, Heater, Prescribed, Run, Scene

AWAY = ([5.0, 0.0, 0.0], [6.0, 1.0, 1.0])  # m
HISTORY = (np.array([0.0, 30.0]), np.array([300.0, 310.0]))  # s, K


@pytest.fixture(scope="module")
def surface(scene: Scene) -> Surface:
    return surface_of(scene)


def with_run(scene: Scene, **changes: Any) -> Scene:
    """The scene with its lamp's run changed."""
    return replace(scene, runs=scene.runs | {"lamp": replace(scene.runs["lamp"], **changes)})


@pytest.mark.parametrize(
    ("key", "stated"),
    [
        ("insulated[0]", {"insulated": (Box(*AWAY),)}),
        ("air[0].box", {"air": (Air(Box(*AWAY), 4.0, 300.0),)}),
        ("prescribed[0].box", {"prescribed": (Prescribed(*map(np.array, AWAY), *HISTORY),)}),
    ],
)
def test_a_box_away_from_the_surface_is_refused_whatever_it_is_for(
    key: str, stated: dict[str, Any], scene: Scene, surface: Surface
) -> None:
    with pytest.raises(InputError, match="no part of the surface lies in this box") as caught:
        check_places(with_run(scene, **stated), surface)
    assert caught.value.where == f"{scene.folder / 'scene.json'}: runs.lamp.{key}"
    assert "5.0" in str(caught.value.value) and "metres" in caught.value.remedy


@settings(max_examples=60, deadline=None)
@given(low=st.tuples(*[st.floats(-0.5, 1.4)] * 3), size=st.tuples(*[st.floats(0.0, 0.6)] * 3))
def test_a_box_meets_a_convex_body_where_it_reaches_in_and_is_not_wholly_within(
    low: tuple[float, ...], size: tuple[float, ...], scene: Scene, surface: Surface
) -> None:
    least, span = surface.vertices.min(0), np.ptp(surface.vertices, axis=0)
    box = Box(least + np.array(low) * span, least + (np.array(low) + np.array(size)) * span)
    lowest, highest = np.array(low), np.array(low) + np.array(size)
    reaches = bool((highest >= 0).all() and (lowest <= 1).all())
    within = bool((lowest > 0).all() and (highest < 1).all())
    edge = np.abs(np.concatenate([lowest, lowest - 1, highest, highest - 1])).min()
    if edge < 1e-4:  # within rounding of the surface either answer is right
        return
    stated = with_run(scene, insulated=(box,))
    if reaches and not within:
        check_places(stated, surface)
        return
    with pytest.raises(InputError, match="no part of the surface"):
        check_places(stated, surface)


def test_a_box_as_flat_as_the_face_that_it_picks_is_taken(scene: Scene, surface: Surface) -> None:
    low, high = surface.vertices.min(0), surface.vertices.max(0)
    check_places(with_run(scene, insulated=(Box([*low[:2], high[2]], high),)), surface)


def test_the_box_of_a_run_that_is_not_asked_for_is_looked_at_before_any_mesh(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("meshed")

    monkeypatch.setattr("thermo.inverse._body.tetrahedralise", never)
    with pytest.raises(InputError, match="no part of the surface"):
        simulate(with_run(scene, insulated=(Box(*AWAY),)), "cooling")


def lamp(run: Run, **changes: Any) -> Heater:
    parts = ("centre", "direction", "radius", "power", "until")
    return Heater(**{**{name: getattr(run.heater, name) for name in parts}, **changes})


def test_a_lamp_that_shines_away_from_the_object_is_refused(scene: Scene, surface: Surface) -> None:
    run = scene.runs["lamp"]
    assert run.heater is not None
    way = run.heater.direction
    far = float(np.max(surface.vertices @ way))
    # Its centre on the side that is lit, within, on the far side, and beyond that.
    for along in (float(np.min(surface.vertices @ way)), far - 1e-3, far):
        check_places(with_run(scene, heater=lamp(run, centre=_at(surface, way, along))), surface)
    beyond = lamp(run, centre=_at(surface, way, far + 1e-3))
    with pytest.raises(InputError, match="shines away from the object") as caught:
        check_places(with_run(scene, heater=beyond), surface)
    assert caught.value.where.endswith("runs.lamp.heater.direction")
    assert "0.001 m behind" in str(caught.value.value)
    turned = lamp(run, centre=_at(surface, way, far - 1.0), direction=-way)
    with pytest.raises(InputError, match="shines away from the object"):
        check_places(with_run(scene, heater=turned), surface)


def _at(surface: Surface, way: np.ndarray, along: float) -> np.ndarray:
    """A point [m] on a line through the object's middle, by how far along `way` it is."""
    middle = (surface.vertices.min(0) + surface.vertices.max(0)) / 2
    return middle + (along - middle @ way) * way


def test_a_wide_lamp_whose_axis_passes_far_away_is_refused(scene: Scene, surface: Surface) -> None:
    # Millimetres for metres: a spot as wide as that would light the object evenly.
    run, size = scene.runs["lamp"], surface.diagonal()
    assert run.heater is not None
    middle, way = (surface.vertices.min(0) + surface.vertices.max(0)) / 2, run.heater.direction
    across = np.cross(way, [0.3, 0.5, 0.7])
    across /= np.linalg.norm(across)

    def wide(far: float) -> Scene:
        centre = middle + far * size * across - 1e3 * way
        return with_run(scene, heater=lamp(run, centre=centre, radius=10 * size))

    check_places(wide(9.9), surface)
    fault = refused(wide(10.1), surface, "axis passes far from the object")
    assert f"{10.1 * size:.3g} m" in fault.value and "metres" in fault.remedy


def refused(stated: Scene, surface: Surface, words: str) -> InputError:
    """The error of a lamp whose centre is wrong."""
    with pytest.raises(InputError, match=words) as caught:
        check_places(stated, surface)
    assert caught.value.where.endswith("runs.lamp.heater.centre")
    return caught.value


def test_a_spot_beside_the_object_is_refused(scene: Scene, surface: Surface) -> None:
    # Scaled to its power, the tail of its bell would light the edge with all of it.
    run, down = scene.runs["lamp"], np.array([0.0, 0.0, -1.0])
    low, high = surface.vertices.min(0), surface.vertices.max(0)

    def spot(beside: float, radius: float) -> Scene:
        centre = np.array([high[0] + beside * radius, 0.4 * low[1] + 0.6 * high[1], high[2] + 0.1])
        return with_run(scene, heater=lamp(run, centre=centre, direction=down, radius=radius))

    check_places(spot(4.9, 1e-3), surface)
    # One within the object may lie between the corners of large triangles.
    check_places(spot(-20.0, 1e-5), surface)
    fault = refused(spot(5.1, 1e-3), surface, "spot lies beside the object")
    assert "passes 0.0051 m beside" in fault.value and "0.005 m" in fault.limit


def test_a_scene_without_a_file_is_told_by_its_run_alone(
    scene: Scene, surface: Surface, tmp_path: Path
) -> None:
    stated = replace(with_run(scene, insulated=(Box(*AWAY),)), folder=tmp_path)
    with pytest.raises(InputError) as caught:
        check_places(stated, surface)
    assert caught.value.where == "runs.lamp.insulated[0]"
