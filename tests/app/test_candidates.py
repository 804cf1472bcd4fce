"""Runs that could be made: what is other about them, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from thermo.app._candidates import build_candidates
from thermo.errors import InputError
from thermo.observe import Course, Heater, Scene, read_scene


@pytest.fixture(scope="module")
def scene(block: Path) -> Scene:
    return read_scene(block)


def test_a_candidate_is_like_a_run_but_for_what_is_said(scene: Scene) -> None:
    section = {
        "hot": {"like": "cooling", "initial_temperature": 350},
        "bright": {"like": "lamp", "power": 3.0, "centre": [0.0, 0.0, 0.02], "duration": 60.0},
    }
    found = build_candidates(section, scene)
    assert found["hot"].initial_temperature == 350.0 and found["hot"].heater is None
    assert found["hot"].ambient_temperature == scene.runs["cooling"].ambient_temperature
    bright, lamp = found["bright"], scene.runs["lamp"]
    assert bright.heater is not None and lamp.heater is not None
    assert bright.heater.power == 3.0 and bright.heater.radius == lamp.heater.radius
    assert np.array_equal(bright.heater.centre, [0.0, 0.0, 0.02])
    assert bright.recording.time[-1] == pytest.approx(60.0)
    assert bright.recording.temperature.shape == lamp.recording.temperature.shape
    assert build_candidates(None, scene) == {}


def test_a_lamp_keeps_its_course(scene: Scene) -> None:
    lamp = scene.runs["lamp"].heater
    assert lamp is not None
    course = Course([0.0, 9.0], [0.5, 1.0])
    logged = Heater(lamp.centre, lamp.direction, lamp.radius, lamp.power, lamp.until, 0.0, course)
    runs = {"lamp": replace(scene.runs["lamp"], heater=logged)}
    found = build_candidates({"bright": {"like": "lamp", "power": 3.0}}, replace(scene, runs=runs))
    assert found["bright"].heater is not None and found["bright"].heater.course is course


def test_another_camera_sees_as_many_other_places(scene: Scene) -> None:
    section = {"below": {"like": "cooling", "camera": [0.01, 0.006, -0.3]}}
    record, like = build_candidates(section, scene)["below"].recording, scene.runs["cooling"]
    assert record.points.shape == like.recording.points.shape
    assert np.allclose(record.points[:, 2], 0.0)
    assert record.temperature.shape == like.recording.temperature.shape
    assert record.quiet is not None and record.quiet.shape[1] == len(record.points)
    assert np.isin(record.temperature[record.valid], like.recording.temperature).all()


@pytest.mark.parametrize(
    ("section", "where", "part"),
    [
        (["hot"], "candidates", "initial_temperature"),
        ({"hot": 3}, "candidates.hot", "like"),
        ({"hot": {"like": "cooling", "colour": 1}}, "candidates.hot", "duration"),
        ({"hot": {"initial_temperature": 350}}, "candidates.hot.like", "cooling"),
        ({"hot": {"like": "bath"}}, "candidates.hot.like", "cooling"),
        ({"hot": {"like": "cooling", "power": 3.0}}, "candidates.hot", "heater"),
        ({"hot": {"like": "lamp", "power": "much"}}, "candidates.hot.power", "number"),
        ({"hot": {"like": "lamp", "power": -1.0}}, "candidates.hot.power", "0"),
        ({"hot": {"like": "lamp", "camera": 3}}, "candidates.hot.camera", "[x,y,z]"),
        ({"hot": {"like": "lamp", "camera": [0.01, 0.006, 0.004]}}, "candidates.hot.camera", "[m]"),
        ({"hot": {"like": "lamp", "duration": 0}}, "candidates.hot.duration", "0"),
        ({"hot": {"like": "cooling", "initial_temperature": 25}},
         "candidates.hot.initial_temperature", ""),
    ],
)  # fmt: skip
def test_what_no_run_could_be_is_refused(section: Any, where: str, part: str, scene: Scene) -> None:
    with pytest.raises(InputError) as caught:
        build_candidates(section, scene)
    assert caught.value.where == where and part in caught.value.limit
