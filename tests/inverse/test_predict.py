"""Prediction and simulation: scores by hand, held-out runs, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import equinox as eqx
import numpy as np
import pytest
from box_scene import FRAMES, SIZE, edit, temperatures

from thermo.errors import InputError
from thermo.inverse import (
    Estimate,
    Meshing,
    Prediction,
    Scores,
    predict,
    save_estimate,
    score,
    simulate,
    weighted_quantile,
)
from thermo.mesh import Surface, face_areas
from thermo.observe import Recording, Scene

from .conftest import START

pytestmark = pytest.mark.usefixtures("bricks")


@pytest.fixture(scope="module")
def rough(fitted: Estimate) -> Estimate:
    """The fit with a field that grows from 0.4 to 1.6 along the block."""
    mesh, field = fitted.mesh, fitted.fields["conductivity"]
    cells, faces = (along(mesh.nodes[corners].mean(1)) for corners in (mesh.cells, mesh.faces))
    return replace(fitted, fields={"conductivity": replace(field, cells=cells, faces=faces)})


def along(points: np.ndarray) -> np.ndarray:
    """From 0.4 to 1.6 [W/m/K] along the block."""
    return 0.4 + 1.2 * points[:, 0] / SIZE[0]


@pytest.fixture(scope="module")
def quadratic(meshing: Meshing) -> Meshing:
    return Meshing(order=2, max_nodes=meshing.max_nodes, cache=meshing.cache)


@pytest.fixture(scope="module")
def fine(meshing: Meshing) -> Meshing:
    """Of so many nodes that edges may be half as long."""
    return Meshing(order=2, max_nodes=20 * meshing.max_nodes, cache=meshing.cache)


@pytest.fixture(scope="module")
def predicted(scene: Scene, fitted: Estimate, fine: Meshing) -> dict[str, Prediction]:
    return predict(scene, fitted, meshing=fine)


def by_hand(simulated: np.ndarray, measured: np.ndarray) -> Scores:
    difference = [abs(float(x)) for x in (simulated - measured).ravel() if np.isfinite(x)]
    mean = sum(difference) / len(difference)
    square = sum(x * x for x in difference) / len(difference)
    return Scores(mean, square**0.5, max(difference))


def test_scores_of_a_small_table() -> None:
    measured = np.array([[1.0, np.nan], [2.0, 4.0]])
    found = score(np.array([[1.5, 9.0], [2.0, 2.0]]), measured)
    assert found.mae == pytest.approx(2.5 / 3)
    assert found.rmse == pytest.approx((4.25 / 3) ** 0.5)
    assert found.max == 2.0


def test_the_held_out_run_is_predicted_at_its_samples_and_frames(
    predicted: dict[str, Prediction], scene: Scene
) -> None:
    assert list(predicted) == ["test_lamp"]
    found, recording = predicted["test_lamp"], scene.runs["test_lamp"].recording
    assert np.array_equal(found.points, recording.points)
    assert np.array_equal(found.time, FRAMES)
    assert np.array_equal(np.isnan(found.measured), ~recording.valid)
    assert np.sqrt(np.mean((found.temperature - temperatures()["test_lamp"]) ** 2)) < 0.06
    assert found.nodal.shape == (len(found.nodal_time), len(found.mesh.nodes))
    assert found.nodal_time[0] == 0 and np.allclose(found.nodal[0], 295.0)
    assert found.nodal_time[-1] == 30 and found.nodal[-1].max() > 297


def test_scores_are_those_of_the_temperatures(predicted: dict[str, Prediction]) -> None:
    found = predicted["test_lamp"]
    wanted = by_hand(found.temperature, found.measured)
    for name in ("mae", "rmse", "max"):
        assert getattr(found.scores["spatial"], name) == pytest.approx(
            getattr(wanted, name), rel=1e-12
        )
    # A uniform field is its own median.
    assert found.scores["median"] == found.scores["spatial"]


def test_it_says_about_how_much_its_cells_make_wrong(
    predicted: dict[str, Prediction], scene: Scene, fitted: Estimate, quadratic: Meshing
) -> None:
    few = predict(scene, fitted, meshing=quadratic)["test_lamp"]
    found = predicted["test_lamp"]
    assert len(found.mesh.nodes) > 2 * len(few.mesh.nodes), "as fine as its nodes allow"
    assert found.cells is not None and few.cells is not None
    assert found.cells.shape == FRAMES.shape and (found.cells >= 0).all()
    # Beside what the fit itself is off by, both are as wrong as they are apart and say.
    apart = np.sqrt(((few.temperature - found.temperature) ** 2).mean())
    told = np.sqrt((few.cells**2).mean())
    assert apart / 4 < told < 4 * apart
    assert np.sqrt((found.cells**2).mean()) < told


def test_the_median_is_that_of_the_field_over_the_surface(
    scene: Scene, rough: Estimate, quadratic: Meshing
) -> None:
    field = rough.fields["conductivity"]
    middle = weighted_quantile(field.faces, face_areas(rough.mesh), 0.5)
    varied = predict(scene, rough, meshing=quadratic)["test_lamp"].scores
    flat = predict(scene, uniform(rough, middle), meshing=quadratic)["test_lamp"].scores
    # The two meshes differ a little: a mesh follows the least diffusivity of its body.
    assert varied["median"].rmse == pytest.approx(flat["spatial"].rmse, rel=1e-2)
    assert varied["spatial"].rmse != pytest.approx(varied["median"].rmse, rel=0.05)


def test_a_folder_predicts_as_the_estimate_that_it_holds(
    block: Path,
    fitted: Estimate,
    predicted: dict[str, Prediction],
    fine: Meshing,
    tmp_path: Path,
) -> None:
    save_estimate(tmp_path / "estimate.npz", fitted)
    said: list[str] = []
    again = predict(block, tmp_path, meshing=fine, say=said.append)["test_lamp"]
    assert len(said) == 1 and said[0].startswith("predicting test_lamp: meshing")
    assert np.allclose(again.temperature, predicted["test_lamp"].temperature, rtol=0, atol=1e-9)


def test_the_prediction_does_not_look_at_the_measurement(
    scene: Scene, fitted: Estimate, predicted: dict[str, Prediction], fine: Meshing
) -> None:
    run = scene.runs["test_lamp"]
    recording = replace_temperature(run.recording)
    changed = replace(scene, runs={**scene.runs, "test_lamp": replace(run, recording=recording)})
    found = predict(changed, fitted, meshing=fine)["test_lamp"]
    assert np.array_equal(found.temperature, predicted["test_lamp"].temperature)
    assert found.scores["spatial"].mae > 5


def replace_temperature(recording: Recording) -> Recording:
    return Recording(recording.points, recording.time, recording.temperature + 9.0, recording.valid)


def test_unknown_runs_and_missing_estimates_are_refused(
    scene: Scene, fitted: Estimate, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match="unknown run"):
        predict(scene, fitted, runs=("nope",))
    with pytest.raises(InputError, match="cannot be read"):
        predict(scene, tmp_path)


def uniform(estimate: Estimate, value: float) -> Estimate:
    field = estimate.fields["conductivity"]
    cells, faces = np.full_like(field.cells, value), np.full_like(field.faces, value)
    return replace(estimate, fields={"conductivity": replace(field, cells=cells, faces=faces)})


def test_a_prediction_may_have_more_nodes_than_a_fit(
    scene: Scene, fitted: Estimate, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Meshing] = []

    def stop(scene: Scene, surface: Surface, diffusivity: float, meshing: Meshing) -> float:
        asked.append(meshing)
        raise KeyboardInterrupt

    monkeypatch.setattr("thermo.inverse._predict._affordable", stop)
    with pytest.raises(KeyboardInterrupt):
        predict(scene, fitted)
    assert asked[0].max_nodes > 2 * Meshing().max_nodes and asked[0].order == 2


def test_a_simulation_is_a_prediction_with_uniform_values(
    block: Path, scene: Scene, fitted: Estimate, quadratic: Meshing
) -> None:
    said: list[str] = []
    found = simulate(block, "test_lamp", values=START, meshing=quadratic, say=said.append)
    assert len(said) == 1 and said[0].startswith("simulating test_lamp: meshing")
    same = uniform(fitted, START["conductivity"])
    wanted = predict(scene, same, meshing=quadratic)["test_lamp"]
    assert np.array_equal(found.mesh.nodes, wanted.mesh.nodes)
    assert np.allclose(found.temperature, wanted.temperature, rtol=0, atol=1e-6)
    assert list(found.scores) == ["stated"]
    assert found.scores["stated"] == score(found.temperature, found.measured)
    assert found.cells is not None and wanted.cells is not None
    assert np.allclose(found.cells, wanted.cells, rtol=0, atol=1e-6)
    assert found.scores["stated"].rmse > 0.5, "three times the true conductivity"


def test_a_simulation_that_leaves_what_temperatures_there_are_is_refused(
    scene: Scene, quadratic: Meshing
) -> None:
    run = scene.runs["test_lamp"]
    lamp = run.heater
    assert lamp is not None
    # Kilowatts for a square metre, taken to be watts: no step can follow what that radiates.
    strong = replace(run, heater=eqx.tree_at(lambda one: one.power, lamp, 1e9))
    changed = replace(scene, runs=scene.runs | {"test_lamp": strong}, emissivity=0.9)
    with pytest.raises(InputError, match="temperatures that there cannot be") as caught:
        simulate(changed, "test_lamp", values=START, meshing=quadratic)
    assert caught.value.where.endswith("runs.test_lamp")
    assert "1e+09 W" in caught.value.remedy


def test_diffusivity_and_a_scene_that_states_it_say_the_same(
    block: Path, scene: Scene, quadratic: Meshing
) -> None:
    stated = replace(scene.material, conductivity=START["conductivity"])
    wanted = simulate(replace(scene, material=stated), "test_lamp", meshing=quadratic)
    values = {"diffusivity": START["conductivity"] / (1100.0 * 1400.0)}
    found = simulate(block, "test_lamp", values=values, meshing=quadratic)
    assert np.allclose(found.temperature, wanted.temperature, rtol=0, atol=1e-6)


def test_a_simulation_needs_a_conductivity(own: Path) -> None:
    table = {"name": "epoxy", "density": 1100.0, "heat_capacity": 1400.0, "conductivity": None}
    edit(own, material=table)
    with pytest.raises(InputError) as caught:
        simulate(own, "lamp")
    assert "conductivity" in caught.value.what
    assert "material.conductivity" in caught.value.where


@pytest.mark.parametrize("value", [-0.2, float("nan")])
def test_a_simulation_refuses_values_that_make_no_sense(value: float, scene: Scene) -> None:
    with pytest.raises(InputError, match="not positive"):
        simulate(scene, "lamp", values={"conductivity": value})
    with pytest.raises(InputError, match="unknown run"):
        simulate(scene, "nope")
