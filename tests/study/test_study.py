"""Studies: what a row records, going on where one stopped, tables beside the paper's, refusals."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from box_scene import CONDUCTIVITY, edit, write_block

from thermo.errors import InputError
from thermo.inverse import LevenbergMarquardt, Meshing, Stepping, Uniform
from thermo.observe import read_scene
from thermo.study import PRESETS, ROWS, Case, Preset, Row, paper_cases, study, study_row, truth
from thermo.study import _row_study as module
from thermo.study import _study as many

LAMP = Row("block", "lamp", "conductivity", 0.2, 0.9, 0.5, known={}, start=2.0)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of scenes, with the block in it."""
    folder = tmp_path_factory.mktemp("scenes")
    write_block(folder / "block")
    return folder


@pytest.fixture(scope="module")
def preset(tmp_path_factory: pytest.TempPathFactory) -> Preset:
    meshing = Meshing(order=1, max_nodes=1500, cache=tmp_path_factory.mktemp("meshes"))
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
    return study_row(case, kept)


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
    assert study_row(case, kept) == record
    for other in (replace(case, seed=1), replace(case, noisy=True), replace(case, held_out=True)):
        with pytest.raises(RuntimeError, match="this would be fitted"):
            study_row(other, kept)


def test_noise_is_put_on_what_is_fitted_and_not_on_what_is_predicted(case: Case) -> None:
    scene = read_scene(case.data / "block")
    seen = module._seen(replace(case, noisy=True), scene)
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


def made(row: str, **more: Any) -> dict[str, Any]:
    """A record as `study_row` leaves it."""
    numbers = {"error": 0.01, "ratio": 1.0, "width": 0.02, "expected": 0.005, "rmse": 0.03}
    words = {"row": row, "preset": "best", "noise": "none", "informed": True, "seconds": 9.0}
    return {**numbers, **words, **more}


def test_the_tables_stand_beside_the_papers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    errors = {kind: {"mae": 0.01, "rmse": 0.02, "max": 0.3} for kind in ("spatial", "median")}
    held_out = {"warming": errors, "heating": errors}
    records = [made("bunny-cooling"), made("car-heating", held_out=held_out)]
    left = iter(records)
    monkeypatch.setattr(many, "study_row", lambda *_: next(left))
    told: list[int] = []
    cases = [
        Case(ROWS[name], "best", PRESETS["best"], tmp_path, noisy=False, held_out=False)
        for name in ("bunny-cooling", "car-heating")
    ]
    got, text = study(cases, tmp_path, on_case=told.append)
    assert got == records and told == [1, 2]
    with (tmp_path / "recovery.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [row["paper error"] for row in rows] == ["0.207", "0.147"]
    with (tmp_path / "transfer.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["test"], row["paper spatial mae"]) for row in rows] == [
        ("warming", "0.485"), ("heating", "1.505"),
    ]  # fmt: skip
    assert "bunny-cooling" in text and "1.505" in text
    page = (tmp_path / "tables.md").read_text().splitlines()
    assert page[0].startswith("| scene |") and page[2].startswith("| bunny-cooling | best | none |")
    assert {line.count("|") for line in page[:4]} == {len(page[0].split("|")) - 1}


def scenes(folder: Path, *names: str) -> Path:
    for name in names:
        (folder / name).mkdir()
        (folder / name / "scene.json").write_text("{}")
    return folder


def test_the_cases_of_a_study(tmp_path: Path) -> None:
    folder = scenes(tmp_path, *{row.object for row in ROWS.values()})
    asked: dict[str, Any] = {"presets": ["best", "paper"], "noises": ["none", "camera"]}
    full = paper_cases(folder, rows=None, size="full", **asked)
    assert len(full) == 12 * 2 * 2 and len({case.name() for case in full}) == 48
    assert len({case.key() for case in full}) == 48
    assert all(case.held_out and case.preset == PRESETS[case.preset_name] for case in full)
    quick = paper_cases(folder, rows=None, size="quick", **asked)
    assert len(quick) == 8 and not any(case.held_out for case in quick)
    assert {case.preset.meshing.max_nodes for case in quick} == {many.QUICK_NODES}
    # Another folder of meshes is no other question.
    (moved,) = paper_cases(
        folder, rows=["cube-cooling"], presets=["best"], noises=["none"], size="full",
        cache=tmp_path / "elsewhere",
    )  # fmt: skip
    assert moved.key() in {case.key() for case in full}


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ({"rows": ["cube-warming"]}, "rows"),
        ({"presets": ["bestest"]}, "presets"),
        ({"presets": []}, "presets"),
        ({"noises": ["loud"]}, "noise"),
        ({"rows": ["bear-cooling"]}, "data"),
    ],
)
def test_names_that_there_are_not_are_refused(
    change: dict[str, Any], where: str, tmp_path: Path
) -> None:
    asked = {"rows": ["cube-cooling"], "presets": ["best"], "noises": ["none"], "size": "full"}
    with pytest.raises(InputError) as caught:
        paper_cases(scenes(tmp_path, "cube"), **{**asked, **change})
    assert caught.value.where == where and caught.value.remedy


def test_the_published_numbers_are_those_of_the_papers_table() -> None:
    # Sums over the table as it is printed: a wrong digit changes them.
    rows = list(ROWS.values())
    assert math.isclose(sum(row.error for row in rows), 3.224)
    assert math.isclose(sum(row.ratio for row in rows), 11.336)
    assert math.isclose(sum(row.width for row in rows), 9.819)
