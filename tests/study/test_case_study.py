"""Cases: what a fit records, that it is not done twice, noise, truth, a guess without data."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from box_scene import CONDUCTIVITY, edit, write_block

from thermo.errors import InputError
from thermo.inverse import LevenbergMarquardt, Meshing, RunFit, Stepping, Uniform
from thermo.observe import read_scene
from thermo.study import Case, Preset, Row, study_case, truth
from thermo.study import _case_study as module
from thermo.study._maps import error_at_the_end

pytestmark = pytest.mark.usefixtures("bricks")

LAMP = Row("block", "lamp", "conductivity", 0.2, 0.9, 0.5, known={}, start=2.0)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of scenes, with the block in it."""
    folder = tmp_path_factory.mktemp("scenes")
    write_block(folder / "block")
    return folder


@pytest.fixture(scope="module")
def preset(tmp_path_factory: pytest.TempPathFactory) -> Preset:
    cache = tmp_path_factory.mktemp("meshes")
    meshing = Meshing(order=1, max_nodes=1500, corrected=False, cache=cache)
    return Preset(
        Uniform(), LevenbergMarquardt(), stepping=Stepping(tolerance=0.05), meshing=meshing
    )


@pytest.fixture(scope="module")
def case(data: Path, preset: Preset) -> Case:
    return Case(LAMP, "small", preset, data, noisy=False, held_out=False)


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("study")


@pytest.fixture(scope="module")
def record(case: Case, kept: Path) -> dict[str, Any]:
    return study_case(case, kept)


def test_a_row_is_fitted_and_scored(record: dict[str, Any], kept: Path) -> None:
    assert record["row"] == "block-lamp" and record["preset"] == "small"
    assert record["error"] < 0.05 and abs(record["ratio"] - 1) < 0.05 and record["width"] == 0.0
    # A lamp of one watt on a small block of epoxy tells its conductivity well.
    assert 0 < record["expected"] < 0.01 and record["informed"] is True
    assert record["response"] > 0.1 and record["seconds"] > 0
    assert json.loads((kept / "block-lamp-small-none.json").read_text()) == record
    assert [file.name for file in kept.iterdir()] == ["block-lamp-small-none.json"]


def test_what_was_done_is_not_done_again_and_what_differs_is(
    case: Case, kept: Path, record: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: Any, **__: Any) -> None:
        raise RuntimeError("this would be fitted")

    monkeypatch.setattr(module, "sensitivity", refuse)
    assert study_case(case, kept) == record
    for other in (replace(case, seed=1), replace(case, noisy=True), replace(case, held_out=True)):
        with pytest.raises(RuntimeError, match="this would be fitted"):
            study_case(other, kept)


def test_noise_is_put_on_what_is_fitted_and_not_on_what_is_predicted(case: Case) -> None:
    scene = read_scene(case.data / "block")
    seen = replace(case, noisy=True).scene()
    for name, run in scene.runs.items():
        same = bool((seen.runs[name].recording.temperature == run.recording.temperature).all())
        assert same == run.held_out


def test_the_truth_is_read_for_scores_and_missed_where_it_is_not_told(
    data: Path, tmp_path: Path
) -> None:
    scene = read_scene(data / "block")
    assert truth(scene, "conductivity") == CONDUCTIVITY
    assert truth(scene, "scaled_convection") == pytest.approx(25.0 / (1100.0 * 1400.0))
    silent = edit(write_block(tmp_path / "block"), truth={})
    with pytest.raises(InputError, match="does not tell the truth"):
        truth(read_scene(silent), "conductivity")


def test_a_repeated_fit_is_not_asked_what_is_to_be_expected_and_starts_elsewhere(
    case: Case, record: dict[str, Any], tmp_path: Path
) -> None:
    repeat = replace(case, part="ensembles", start=0.5, seed=3)
    found = study_case(repeat, tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == [f"{repeat.name()}.json"]
    assert repeat.name() == "block-lamp-small-none-start-0.5-seed-3"
    assert "expected" not in found and (found["start"], found["seed"]) == (0.5, 3)
    # Either ends where a step promises a ten-thousandth of the loss. Cells as coarse as these leave
    # some forty times the noise, so that this is eight of its deviations, which are 3.5e-4.
    assert found["ratio"] == pytest.approx(record["ratio"], rel=6e-3)
    assert found["final_mae"] == pytest.approx(record["final_mae"], rel=0.1)


def test_held_out_runs_are_predicted_and_mapped(
    case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "PREDICTION_NODES", 1500)
    monkeypatch.setattr(module, "HELD_OUT", {"heating": "test_lamp", "warming": "there is none"})
    found = study_case(replace(case, part="smoothness", step=0.1, held_out=True), tmp_path)
    assert list(found["held_out"]) == ["heating"]
    with np.load(tmp_path / "block-lamp-small-none-step-0.1-maps.npz") as maps:
        assert np.average(maps["ratio"], weights=maps["areas"]) == pytest.approx(found["ratio"])
        assert maps["faces"].shape == (len(maps["ratio"]), 3) and maps["nodes"].shape[1] == 3
        assert maps["error_heating"].mean() == pytest.approx(
            found["held_out"]["heating"]["spatial"]["mae"], rel=1e-2
        )
        assert len(maps["points"]) == len(maps["fitted"]) and 0 < np.nanmax(maps["fitted"]) < 5


def test_the_map_of_a_heated_run_is_of_the_last_frame_with_the_lamp_on(case: Case) -> None:
    run = case.scene().runs["lamp"]
    assert run.heater is not None
    end = float(run.heater.until)
    time = np.array([0.5 * end, end, 1.5 * end])
    simulated = np.array([[1.0], [2.0], [3.0]])
    fit = RunFit(1.0, 0.1, 0.0, 0.1, time, np.zeros((1, 3)), np.zeros((3, 1)), simulated)
    assert error_at_the_end(run, fit) == pytest.approx([2.0])
    assert error_at_the_end(replace(run, heater=None), fit) == pytest.approx([3.0])


def test_without_an_optimiser_the_prior_is_the_answer(
    case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write_block(tmp_path / "scenes" / "block")
    capacity = 1100.0 * 1400.0
    edit(folder, truth={"diffusivity": CONDUCTIVITY / capacity})
    monkeypatch.setattr(module, "PREDICTION_NODES", 1500)
    monkeypatch.setattr(module, "HELD_OUT", {"heating": "test_lamp"})
    guess = replace(
        case, data=folder.parent, preset=replace(case.preset, optimiser=None), held_out=True,
        row=replace(LAMP, quantity="diffusivity", start=1.0),
    )  # fmt: skip
    found = study_case(guess, tmp_path)
    # About even in the logarithm from 0.03 to 300 W/m/K: 3 W/m/K.
    assert found["ratio"] * CONDUCTIVITY == pytest.approx(3.0, rel=0.05)
    assert found["error"] == pytest.approx(found["ratio"] - 1) and found["width"] == 0.0
    assert found["rmse"] > 0.5 and found["held_out"]["heating"]["spatial"]["mae"] > 0.2
    air = replace(guess, row=replace(LAMP, quantity="scaled_convection", start=3.0,
                                     known={"conductivity": CONDUCTIVITY}))  # fmt: skip
    assert study_case(replace(air, held_out=False), tmp_path)["ratio"] == pytest.approx(3.0)
