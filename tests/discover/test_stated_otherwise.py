"""A scene that states other values than an estimate took is told of; nothing else is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from box_scene import write_block
from verdicts import estimate

from thermo.discover import stated_otherwise
from thermo.inverse import Estimate, RecoveredField, law_of, save_estimate
from thermo.observe import Scene, TemperatureTable, read_scene


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_block(tmp_path_factory.mktemp("block"))


@pytest.fixture
def scene(folder: Path) -> Scene:
    """One that states what the estimates of `verdicts` took."""
    found = read_scene(folder)
    stated = estimate(0.0).stated
    heat = stated.capacity / found.material.density
    material = replace(found.material, conductivity=None, heat_capacity=heat)
    return replace(
        found, material=material, convection=stated.convection, emissivity=stated.emissivity
    )


def saved(tmp_path: Path, made: Estimate) -> Path:
    save_estimate(tmp_path / "estimate.npz", made)
    return tmp_path


def test_the_same_values_are_no_remark(scene: Scene, tmp_path: Path) -> None:
    there = saved(tmp_path, estimate(0.0))
    assert stated_otherwise(there, scene) == []
    # What was found takes the place of what is stated.
    conducts = replace(scene, material=replace(scene.material, conductivity=17.0))
    assert stated_otherwise(there, conducts) == []


def test_each_other_value_is_one_remark(scene: Scene, tmp_path: Path) -> None:
    there = saved(tmp_path, estimate(0.0))
    other = replace(scene, convection=2 * (scene.convection or 0.0), emissivity=0.3)
    other = replace(other, material=replace(other.material, density=2 * other.material.density))
    told = stated_otherwise(there, other)
    assert [line.split("with ")[1].split(" ")[0] for line in told] == [
        "volumetric_heat_capacity", "convection", "emissivity",
    ]  # fmt: skip
    assert "convection 8 W/m2/K, this scene states 16:" in told[1]
    assert "emissivity 0.85, this scene states 0.3:" in told[2]


def test_another_course_over_temperature_is_a_remark(scene: Scene, tmp_path: Path) -> None:
    there = saved(tmp_path, estimate(0.0))
    level = scene.material.volumetric_heat_capacity() / scene.material.density
    table = TemperatureTable((243.15, 343.15), (0.5 * level, 1.5 * level))
    grows = replace(scene, material=replace(scene.material, heat_capacity=table))
    (told,) = stated_otherwise(there, grows)
    assert "another course of the heat capacity over temperature" in told
    made = estimate(0.0)
    again = replace(made, stated=replace(made.stated, capacity_law=law_of(table)))
    assert stated_otherwise(saved(tmp_path, again), grows) == []


def test_a_folder_is_read_and_a_scaled_value_counts_as_found(folder: Path, tmp_path: Path) -> None:
    made = estimate(0.0)
    assert any(
        "convection" in line for line in stated_otherwise(saved(tmp_path, made), folder)
    ) is (read_scene(folder).convection != made.stated.convection)
    old = made.fields["conductivity"]
    scaled = RecoveredField("scaled_convection", "m/s", old.cells * 1e-6, old.faces * 1e-6)
    there = saved(tmp_path, replace(made, fields={"scaled_convection": scaled}))
    assert not any("convection" in line for line in stated_otherwise(there, folder))
