"""The three verbs from end to end, and the files that other programs rely on."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from box_scene import FRAMES, sample_points

from thermo.app import _verbs
from thermo.app._fitted import left_by_search
from thermo.study import Case

from .conftest import SMALL, Command

pytestmark = pytest.mark.usefixtures("bricks")

COARSE = ("mesh=tet4", "mesh.max_nodes=1500", "tolerance=0.05")
PNG = b"\x89PNG"


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the fit on bricks stays: no other file's tests may meet it."""
    return tmp_path_factory.mktemp("bricks") / "fit"


def result(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "result.json").read_text())


def check_figures(folder: Path, names: list[str]) -> None:
    for name in names:
        data = (folder / name).read_bytes()
        assert data.startswith(PNG) and len(data) > 5000, name


def check_recording(folder: Path, name: str) -> np.ndarray:
    with np.load(folder / f"{name}.npz", allow_pickle=False) as stored:
        assert sorted(stored) == ["points", "temperature", "time"]
        assert np.allclose(stored["points"], sample_points())
        assert np.array_equal(stored["time"], FRAMES)
        temperature = stored["temperature"]
    assert temperature.shape == (len(FRAMES), len(sample_points()))
    assert np.isfinite(temperature).all() and np.allclose(temperature[0], 295.0, atol=1e-6)
    return temperature


def check_series(folder: Path, name: str) -> None:
    text = (folder / f"{name}.pvd").read_text()
    files = sorted((folder / name).iterdir())
    assert len(files) == text.count("<DataSet") == 13
    assert all(f'file="{name}/{file.name}"' in text for file in files)
    grid = meshio.read(files[-1])
    assert grid.point_data["temperature"].shape == (len(grid.points),)
    assert grid.point_data["temperature"].max() > 296


def test_invert_leaves_the_result_of_the_contract(fit: Path) -> None:
    found = result(fit)
    field = found["fields"]["conductivity"]
    assert set(field) == {"unit", "median", "p05", "p95"} and field["unit"] == "W/m/K"
    assert 1e-3 < field["p05"] <= field["median"] <= field["p95"] < 2.4
    assert set(found["fit"]["rmse"]) == {"lamp", "cooling"}
    assert all(0 < value < 10 for value in found["fit"]["rmse"].values())
    assert set(found["fit"]["noise"]) == {"lamp", "cooling"}
    assert all(0 < value < 0.1 for value in found["fit"]["noise"].values())
    assert found["success"] is True and found["seconds"] > 0
    # Noise of 0.01 K beside a model error of as much, not raised: one value has no neighbours.
    assert all(0.01 < value < 0.03 for value in found["fit"]["deviation"].values())
    assert found["fit"]["smoothness"] == {}
    assert set(found["fit"]["final_mae"]) == {"lamp", "cooling"}
    # Adam makes its steps and ends: nothing is taken off.
    assert found["fit"]["defect"] == {"lamp": 0.0, "cooling": 0.0}
    assert found["mesh"]["order"] == 1 and found["verb"] == "invert"
    assert len(found["fit"]["loss"][0]) == 3
    assert found["configuration"]["optimiser"]["kind"] == "adam"
    assert {"thermofield", "jax", "numpy"} <= set(found["versions"])


def test_invert_leaves_field_and_figures(fit: Path) -> None:
    found = result(fit)
    with np.load(fit / "field.npz", allow_pickle=False) as stored:
        assert sorted(stored) == ["conductivity", "points"]
        points, values = stored["points"], stored["conductivity"]
    assert points.shape == (len(values), 3) and len(values) > 50
    # Within what the mesher may be off the surface by.
    assert points.min() > -1e-5 and np.allclose(points.max(0), [0.020, 0.012, 0.008], atol=1e-5)
    assert np.allclose(values, found["fields"]["conductivity"]["median"])
    grid = meshio.read(fit / "field.vtu")
    assert np.allclose(grid.cell_data["conductivity"][0], values[0])
    check_figures(
        fit,
        ["field_conductivity.png", "history.png"]
        + [f"{kind}_{run}.png" for kind in ("curves", "residual") for run in ("lamp", "cooling")],
    )
    leftover = [path.name for path in fit.iterdir() if path.name.startswith((".", "tmp"))]
    assert leftover == [] and not (fit / "checkpoint.npz").exists()


def test_invert_says_what_it_found(fit: Path) -> None:
    said = (fit.parent / "said").read_text()
    assert "conductivity" in said and "W/m/K" in said and "rmse [K]" in said
    assert str(fit / "result.json") in said and "mm deep" in said
    # Adam settles nowhere: it goes all its way.
    assert "Made all 3 steps." in said and "Settled" not in said
    assert not (fit / "checkpoint.npz").exists(), "it goes once the result is safe"


def test_predict_scores_the_held_out_run(
    fit: Path, command: Command, block: Path, tmp_path: Path
) -> None:
    out = tmp_path / "predicted"
    words = ("predict", f"data={block}", f"estimate={fit}", f"out={out}")
    outcome = command(*words, "mesh=tet4", "mesh.max_nodes=3000", "tolerance=0.05")
    assert outcome.code == 0, outcome.err
    temperature = check_recording(out, "test_lamp")
    check_series(out, "test_lamp")
    check_figures(out, ["curves_test_lamp.png", "residual_test_lamp.png"])
    assert result(out)["effects"] == []
    # Three steps of Adam explain nothing.
    remarks = result(out)["remarks"]
    poor = [one for one in remarks if "does not explain the recording" in one]
    assert len(poor) == 2 and all(one in outcome.out for one in remarks)
    cells, noise = result(out)["cells"]["test_lamp"], result(out)["noise"]["test_lamp"]
    coarse = [one for one in remarks if one.startswith("Cells make some")]
    assert len(coarse) == (cells["largest"] > noise) == len(remarks) - len(poor)
    assert 0 < cells["rms"] < cells["largest"]
    scores = result(out)["scores"]
    assert set(scores) == {"test_lamp"} and set(scores["test_lamp"]) == {"spatial", "median"}
    with np.load(block / "test_lamp.npz", allow_pickle=False) as stored:
        difference = np.abs(temperature - stored["temperature"])
    assert scores["test_lamp"]["spatial"] == pytest.approx(
        {
            "mae": np.nanmean(difference),
            "rmse": np.sqrt(np.nanmean(difference**2)),
            "max": np.nanmax(difference),
        },
        rel=1e-9,
    )
    assert "test_lamp" in outcome.out and "mae [K]" in outcome.out


def of_the_fit(out: Path) -> list[str]:
    """Remarks of a prediction but what so few cells make wrong."""
    return [one for one in result(out)["remarks"] if not one.startswith("Cells make some")]


@pytest.mark.usefixtures("fit", "unpictured")
def test_a_prediction_tells_what_its_fit_does_not_explain(
    fit: Path, command: Command, block: Path, tmp_path: Path
) -> None:
    told = "The residual of lamp is 9 times its noise: this model does not explain the recording."
    poor = tmp_path / "poor"
    shutil.copytree(fit, poor)
    record = result(poor)
    others = [one for one in record["remarks"] if "does not explain" not in one]
    (poor / "result.json").write_text(json.dumps(record | {"remarks": [*others, told]}))
    out = tmp_path / "predicted"
    quick = ("mesh=tet4", "tolerance=0.5", "mesh.max_nodes=3000")
    outcome = command("predict", f"data={block}", f"estimate={poor}", f"out={out}", *quick)
    assert outcome.code == 0, outcome.err
    assert of_the_fit(out) == [f"Of the fit that this rests on: {told}"]
    assert told in outcome.out
    # A folder may come without the record of its fit.
    (poor / "result.json").unlink()
    outcome = command("predict", f"data={block}", f"estimate={poor}", f"out={out}", *quick)
    assert outcome.code == 0 and of_the_fit(out) == [], outcome.err


@pytest.mark.parametrize(
    ("verdict", "chance", "told"), [("named", 0.4, 0), ("named", 1e-9, 1), ("none_of_mine", 0.4, 1)]
)
def test_what_a_search_left_unexplained_is_told_to_whoever_predicts_from_it(
    tmp_path: Path, verdict: str, chance: float, told: int
) -> None:
    record = {
        "verdict": verdict, "p_value": {"with": chance}, "noise": {"lamp": 0.05},
        "rounds": [
            {"rms_before": {"lamp": 1.7}, "rms_after": {"lamp": 0.4}, "best": "local_convection"},
            {"rms_before": {"lamp": 0.4}, "rms_after": {"lamp": 0.21}, "best": "void"},
        ],
    }  # fmt: skip
    (tmp_path / "verdict.json").write_text(json.dumps(record))
    words = left_by_search(tmp_path)
    assert len(words) == told
    # What came closest is at work in no prediction, and leaves nothing of it.
    unnamed = verdict == "none_of_mine"
    left = "1.7" if unnamed else "0.21"
    assert all(f"lamp {left} K at a noise of 0.05 K" in one for one in words)
    assert all(("closest, local convection, void." in one) is unnamed for one in words)
    # A search that put nothing to work has no rounds, and not every estimate is of a search.
    (tmp_path / "verdict.json").write_text(json.dumps(record | {"rounds": []}))
    assert len(left_by_search(tmp_path)) == told
    assert left_by_search(tmp_path / "none") == ()


def test_simulate_takes_the_values_of_the_command_line(
    command: Command, block: Path, cache: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    out = tmp_path / "simulated"
    words = ("simulate", f"data={block}", "run=lamp", f"out={out}", cache, *COARSE)
    outcome = command(*words, "material.conductivity=2.4")
    assert outcome.code == 0, outcome.err
    temperature = check_recording(out, "lamp")
    check_series(out, "lamp")
    check_figures(out, ["curves_lamp.png", "residual_lamp.png"])
    found = result(out)
    assert set(found["scores"]["lamp"]) == {"stated"} and found["verb"] == "simulate"
    assert found["configuration"]["material"]["conductivity"] == 2.4
    # Of so few cells; on more it is less than noise, and nothing is said.
    (told,) = found["remarks"]
    assert told.startswith("Cells make some ") and " K wrong in lamp at " in told
    assert found["cells"]["lamp"]["largest"] > found["noise"]["lamp"] and told in outcome.out
    request.getfixturevalue("unpictured")
    more = ("material.conductivity=2.4", "surface_exchange.convection=100")
    assert command(*words, *more).code == 0
    windy = check_recording(out, "lamp")
    # The air takes away much more, most of it after the lamp is out.
    assert 0.1 < (windy[-1] - 295).mean() / (temperature[-1] - 295).mean() < 0.8


@pytest.mark.usefixtures("fit", "unpictured")
def test_a_multirun_makes_a_folder_for_each_seed(
    fit: Path, command: Command, block: Path, cache: str, tmp_path: Path
) -> None:
    out = tmp_path / "sweep"
    # The first fit's words, so that nothing is compiled again.
    outcome = command("invert", "-m", f"data={block}", f"out={out}", cache, *SMALL, "seed=0,1")
    assert outcome.code == 0, outcome.err
    assert sorted(path.name for path in out.iterdir() if path.is_dir()) == ["seed-0", "seed-1"]
    for seed in (0, 1):
        found = result(out / f"seed-{seed}")
        assert found["configuration"]["seed"] == seed
        assert found["fields"] == result(fit)["fields"], "a uniform field knows no seed"
    assert list(Path.cwd().iterdir()) == [], "nothing is left in the working folder"
    # Given again, the sweep does what is missing and nothing else.
    before = (out / "seed-0" / "result.json").stat().st_mtime_ns
    (out / "seed-1" / "result.json").unlink()
    again = command("invert", "-m", f"data={block}", f"out={out}", cache, *SMALL, "seed=0,1")
    assert again.code == 0 and again.err.count("finished before") == 1
    assert (out / "seed-0" / "result.json").stat().st_mtime_ns == before
    assert result(out / "seed-1")["configuration"]["seed"] == 1

    gathered = command("ensemble", f"folder={out}")
    assert gathered.code == 0 and "conductivity" in gathered.out, gathered.err
    found = json.loads((out / "ensemble.json").read_text())["fields"]["conductivity"]
    assert found["members"] == 2 and found["relative_deviation"] == 0.0
    assert found["median"] == result(fit)["fields"]["conductivity"]["median"]


def test_a_study_asks_for_its_parts_and_names_its_tables(
    command: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "scenes" / "cube").mkdir(parents=True)
    (tmp_path / "scenes" / "cube" / "scene.json").write_text("{}")
    asked: list[Case] = []

    def made(cases: list[Case], folder: Path, on_case: Callable[[int], None]) -> tuple[list, str]:
        asked.extend(cases)
        on_case(len(cases))
        return [], f"the tables of {folder.name}"

    monkeypatch.setattr(_verbs, "study_cases", made)
    words = ("rows=[cube-heating]", "parts=[smoothness]", "noise=[camera]", "size=quick")
    out = tmp_path / "out"
    got = command("study", "paper", f"data={tmp_path / 'scenes'}", *words, f"out={out}")
    assert got.code == 0, got.err
    assert {(case.part, case.noisy, case.row.name()) for case in asked} == {
        ("smoothness", True, "cube-heating")
    }
    assert "the tables of out" in got.out and str(out / "tables.md") in got.out
