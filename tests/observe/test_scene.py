"""Scene folders: what is read, what is written, and that the two agree."""

from __future__ import annotations

import json
import os
import tempfile
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.observe import (
    QUANTITIES,
    Box,
    Course,
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

POSITIVE = st.floats(1e-6, 1e6)
KELVIN = st.floats(150.0, 5000.0)
METRES = st.floats(-1.0, 1.0)


def vectors(elements: st.SearchStrategy[float]) -> st.SearchStrategy[np.ndarray]:
    return st.tuples(elements, elements, elements).map(np.array)


# Plain functions that draw inside the test: the run-time type checks of the package use `random`,
# which strategies must not.
def drawn_heater(draw: st.DrawFn) -> Heater:
    direction = draw(vectors(METRES).filter(lambda vector: np.abs(vector).max() > 0))
    return Heater(
        draw(vectors(METRES)), direction, draw(POSITIVE), draw(POSITIVE), draw(POSITIVE),
        draw(st.floats(0, 10)), drawn_course(draw) if draw(st.booleans()) else None,
    )  # fmt: skip


def drawn_course(draw: st.DrawFn) -> Course:
    return Course([0.0, 7.0], [draw(st.floats(1e-6, 10)), 0.0])


def drawn_box(draw: st.DrawFn) -> Box:
    corner = draw(vectors(METRES))
    return Box(corner, corner + draw(vectors(st.floats(0, 1))))


def drawn_history(draw: st.DrawFn) -> Prescribed:
    corner = draw(vectors(METRES))
    temperature = np.array(draw(st.lists(KELVIN, min_size=3, max_size=3)))
    return Prescribed(
        corner, corner + draw(vectors(st.floats(0, 1))), np.array([-1.0, 0.5, 9.0]), temperature
    )


def drawn_run(draw: st.DrawFn, name: str) -> Run:
    temperature = np.array(draw(st.lists(KELVIN, min_size=6, max_size=6))).reshape(3, 2)
    # Readings at t = 0 would have to be near the start.
    recording = Recording(np.eye(3)[:2] * 0.01, np.array([0.1, 1.0, 2.5]), temperature)
    heater = drawn_heater(draw) if draw(st.booleans()) else None
    return Run(
        name, recording, draw(KELVIN), draw(KELVIN), draw(KELVIN), heater,
        draw(st.booleans()), tuple(drawn_history(draw) for _ in range(draw(st.integers(0, 2)))),
        tuple(drawn_box(draw) for _ in range(draw(st.integers(0, 2)))),
        draw(st.floats(0, 5)),
    )  # fmt: skip


# Together of a volume that holds as much heat as a solid does.
CAPACITY, DENSITY = st.floats(100, 5000), st.floats(60, 9000)


def drawn_property(draw: st.DrawFn, values: st.SearchStrategy[float]) -> float | TemperatureTable:
    """A number, or a table of temperatures."""
    pairs = st.tuples(KELVIN, values)
    drawn = draw(values | st.lists(pairs, min_size=2, max_size=4, unique_by=lambda pair: pair[0]))
    if isinstance(drawn, float):
        return drawn
    # Readings may have any temperature, and have to lie within.
    ends = {150.0: drawn[0][1], 5000.0: drawn[1][1]}
    temperature, value = zip(*sorted((ends | dict(drawn)).items()), strict=True)
    return TemperatureTable(temperature, value)


def drawn_scene(draw: st.DrawFn, folder: Path) -> Scene:
    surface = folder / "body.stl"
    surface.write_bytes(draw(st.binary(max_size=20)))
    names = draw(st.lists(st.from_regex(r"[a-z0-9][a-z0-9_.-]{0,8}", fullmatch=True),
                          min_size=1, max_size=3, unique=True))  # fmt: skip
    unknown = tuple(draw(st.lists(st.sampled_from(QUANTITIES), unique=True)))
    unknown_conductivity = "conductivity" in unknown
    priors = st.dictionaries(st.sampled_from(QUANTITIES), POSITIVE)
    material = StatedMaterial(
        draw(st.text(min_size=1).filter(str.strip)), draw(DENSITY),
        drawn_property(draw, CAPACITY),
        None if unknown_conductivity and draw(st.booleans()) else drawn_property(draw, POSITIVE),
    )  # fmt: skip
    found = {name: drawn_run(draw, name) for name in names}
    return Scene(
        folder, draw(st.text(min_size=1).filter(str.strip)), surface,
        draw(st.sampled_from(["m", "cm", "mm", "inch"])), material, draw(st.floats(0, 1e4)),
        draw(st.floats(0, 1)), unknown, draw(priors), found, draw(st.floats(0, 0.5)),
    )  # fmt: skip


def assert_same(found: object, expected: object) -> None:
    """Compare two parts of a scene, every number bit for bit."""
    assert type(found) is type(expected)
    if isinstance(expected, np.ndarray):
        np.testing.assert_array_equal(found, expected)
    elif isinstance(expected, tuple):
        assert len(found) == len(expected)
        for one, other in zip(found, expected, strict=True):
            assert_same(one, other)
    elif isinstance(expected, dict):
        assert list(found) == list(expected)
        for name, other in expected.items():
            assert_same(found[name], other)
    elif hasattr(expected, "__dataclass_fields__"):
        for entry in fields(expected):
            if entry.name not in ("folder", "surface_path"):
                assert_same(getattr(found, entry.name), getattr(expected, entry.name))
    else:
        assert found == expected


@settings(max_examples=30, deadline=None)
@given(st.data())
def test_written_scene_reads_back_bit_for_bit(data: st.DataObject) -> None:
    with tempfile.TemporaryDirectory() as name:
        source, target = Path(name) / "source", Path(name) / "deep" / "target"
        source.mkdir()
        scene = drawn_scene(data.draw, source)
        write_scene(target, scene)
        found = read_scene(target)
        assert_same(found, scene)
        assert found.surface_path == target / "surface.stl"
        assert found.surface_path.read_bytes() == scene.surface_path.read_bytes()
        assert os.listdir(target.parent) == ["target"]


def test_every_documented_key_is_read(folder: Path) -> None:
    scene = read_scene(folder)
    assert scene.scale_deviation == 0.01
    assert (scene.object, scene.unit, scene.folder) == ("tetrahedron", "m", folder)
    assert scene.surface_path == folder / "surface.off"
    assert scene.material == StatedMaterial("ABS", 1030.0, 1440.0, None)
    assert isinstance(scene.material.density, float)
    assert (scene.convection, scene.emissivity) == (3.0, 0.92)
    assert scene.unknown == ("conductivity", "convection")
    assert scene.prior == {"convection": 0.3}
    assert list(scene.runs) == ["lamp", "cooling"]
    lamp, cooling = scene.runs["lamp"], scene.runs["cooling"]
    assert (lamp.name, lamp.held_out, cooling.held_out) == ("lamp", True, False)
    assert (lamp.initial_temperature, lamp.ambient_temperature) == (295.15, 294.0)
    assert lamp.radiation_temperature == 293.15
    assert cooling.heater is None and cooling.prescribed == cooling.insulated == cooling.air == ()
    assert lamp.heater is not None
    np.testing.assert_array_equal(lamp.heater.direction, [0.0, 0.0, -1.0])
    assert (lamp.heater.radius, lamp.heater.power) == (0.01, 2.0)
    assert (lamp.heater.until, lamp.heater.rise) == (30.0, 1.0)
    assert lamp.heater.course is not None
    np.testing.assert_array_equal(lamp.heater.course.time, [0.0, 10.0])
    np.testing.assert_array_equal(lamp.heater.course.share, [0.9, 1.0])
    (box,) = lamp.insulated
    np.testing.assert_array_equal([box.low, box.high], [[-1e-3] * 3, [0.05, 0.05, 1e-3]])
    (air,) = lamp.air
    assert (air.convection, air.temperature) == (4.0, 299.0)
    np.testing.assert_array_equal(air.box.high, [0.05, 0.05, 1e-3])
    inline, file = lamp.prescribed
    np.testing.assert_array_equal(inline.box_max, [1e-3, 0.05, 0.05])
    np.testing.assert_array_equal(inline.temperature, [295.0, 296.0, 297.0])
    np.testing.assert_allclose(file.time, [0.0, 60.0])
    np.testing.assert_allclose(file.temperature, [295.15, 296.15])


def test_optional_keys_have_defaults(folder: Path, stated: dict) -> None:
    for key in ("object", "unit", "scale_deviation", "unknown", "prior", "truth", "description"):
        del stated[key]
    stated["material"] = {"density": 1e3, "heat_capacity": 1e3, "conductivity": 1.0}
    for key in ("heater", "held_out", "prescribed", "insulated", "air", "notes"):
        del stated["runs"]["lamp"][key]
    (folder / "scene.json").write_text(json.dumps(stated))
    scene = read_scene(folder / "scene.json")
    assert (scene.object, scene.unit, scene.unknown, scene.prior) == (folder.name, "m", (), {})
    assert scene.scale_deviation == 0.0
    lamp = scene.runs["lamp"]
    assert (lamp.heater, lamp.held_out, lamp.prescribed, lamp.insulated) == (None, False, (), ())
    assert lamp.air == ()


@pytest.mark.parametrize("truth", [None, "nonsense", {"conductivity": "?"}, [1, [2]]])
def test_truth_has_no_influence(truth, folder: Path, stated: dict) -> None:
    expected = read_scene(folder)
    stated["truth"] = truth
    (folder / "scene.json").write_text(json.dumps(stated))
    assert_same(read_scene(folder), expected)


def test_null_is_allowed_for_what_is_to_be_found(folder: Path, stated: dict) -> None:
    stated["unknown"] = ["diffusivity", "scaled_convection", "emissivity"]
    stated["surface_exchange"] = {"convection": None, "emissivity": None}
    (folder / "scene.json").write_text(json.dumps(stated))
    scene = read_scene(folder)
    assert (scene.material.conductivity, scene.convection, scene.emissivity) == (None,) * 3


def test_history_in_npz(folder: Path, stated: dict) -> None:
    stated["runs"]["lamp"]["prescribed"][1]["history"] = "end.npz"
    (folder / "scene.json").write_text(json.dumps(stated))
    np.savez(folder / "end.npz", time=np.array([0.0, 3.0]), temperature=np.array([300.0, 310.0]))
    np.testing.assert_array_equal(
        read_scene(folder).runs["lamp"].prescribed[1].temperature, [300.0, 310.0]
    )


def test_scene_can_be_written_onto_itself(folder: Path) -> None:
    before = read_scene(folder)
    write_scene(folder, before)
    assert_same(read_scene(folder), before)
    assert (folder / "end.csv").exists(), "other files stay"
    assert not [name for name in os.listdir(folder.parent) if name.startswith(f".{folder.name}")]


def test_scene_that_cannot_be_read_back_is_not_written(folder: Path, refuses) -> None:
    scene = read_scene(folder)
    lamp = scene.runs["lamp"]
    bad = replace(scene, runs={"a/b": lamp}, where="scene")
    (folder / "a").mkdir()
    before = sorted(os.listdir(folder))
    refuses(
        lambda: write_scene(folder, bad), where="run", value="a/b", limit="letters",
        remedy="rename",
    )  # fmt: skip
    object.__setattr__(scene.material, "density", -1.0)
    refuses(
        lambda: write_scene(folder, scene), where=f"{folder / 'scene.json'}: material.density",
        value="-1", limit="above 0", remedy="kg/m3",
    )  # fmt: skip
    assert sorted(os.listdir(folder)) == before
    assert json.loads((folder / "scene.json").read_text())["material"]["density"] == 1030


def test_interrupted_write_leaves_the_old_scene(folder: Path, monkeypatch) -> None:
    scene = read_scene(folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(json, "dumps", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_scene(folder, scene)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_unwritable_folder_is_refused(folder: Path, refuses) -> None:
    scene = read_scene(folder)
    (folder / "file").write_text("")
    for target in (folder / "file", folder / "file" / "deeper"):
        refuses(
            lambda target=target: write_scene(target, scene), where=str(target), value="Error",
            limit="written to", remedy="another output",
        )  # fmt: skip


@settings(max_examples=100, deadline=None)
@given(st.tuples(*[st.floats(-1e3, 1e3, allow_subnormal=True)] * 3).filter(lambda v: any(v)))
def test_direction_becomes_a_unit_vector_once(direction: tuple[float, ...]) -> None:
    once = Heater(np.zeros(3), np.array(direction), 0.01, 1.0, 1.0)
    assert np.linalg.norm(once.direction) == pytest.approx(1.0, abs=1e-11)
    assert np.dot(once.direction, direction) > 0
    again = Heater(np.zeros(3), once.direction, 0.01, 1.0, 1.0)
    np.testing.assert_array_equal(again.direction, once.direction)
