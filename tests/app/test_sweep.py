"""Jobs of a multirun: what counts as done."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from thermo.app._sweep import WORDS, finished, job_folder


@pytest.fixture
def settings(tmp_path: Path) -> dict[str, Any]:
    """Settings of a job that has left its result after the data were written."""
    data, out = tmp_path / "data", tmp_path / "out"
    data.mkdir()
    out.mkdir()
    (data / "scene.json").write_text("{}")
    made = {"data": str(data), "out": str(out), "runs": ["a"], "seed": 1, "initial": {"k": None}}
    (out / "result.json").write_text(json.dumps({"verb": "invert", "configuration": made}))
    os.utime(data / "scene.json", (1e9, 1e9))
    return made


def test_a_finished_job_is_known_by_its_settings(settings: dict[str, Any]) -> None:
    assert finished("invert", settings)
    assert not finished("predict", settings)
    assert not finished("invert", {**settings, "seed": 2})


def test_newer_data_make_a_job_due_again(settings: dict[str, Any]) -> None:
    os.utime(Path(settings["data"]) / "scene.json", (9e9, 9e9))
    assert not finished("invert", settings)


@pytest.mark.parametrize("text", ["", "{", '{"verb": "invert"}'])
def test_a_damaged_result_is_none(settings: dict[str, Any], text: str) -> None:
    (Path(settings["out"]) / "result.json").write_text(text)
    assert not finished("invert", settings)


def test_no_folder_and_no_data_are_none(settings: dict[str, Any]) -> None:
    assert not finished("invert", {**settings, "out": "nowhere"})
    assert not finished("invert", {**settings, "data": "nowhere"})


def test_a_folder_is_named_by_what_differs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(WORDS, json.dumps(["data=x", "seed=0,1", "init=0.3,3"]))
    out = Path("sweep")
    assert job_folder(out, ["data=x", "seed=1", "init=0.3"], 2) == out / "seed-1_init-0.3"
    assert job_folder(out, ["runs=[a,b]", "seed=1"], 0) == out / "runs-_a_b_seed-1"
    assert job_folder(out, ["data=x"], 2) == out / "2"
    assert job_folder(out, ["note=" + "a" * 200], 7) == out / "7"
    # On a machine that was not told the words of the command.
    monkeypatch.delenv(WORDS)
    assert job_folder(out, ["data=x", "seed=1"], 3) == out / "3"
