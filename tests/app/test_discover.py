"""`thermo discover`: what it asks for, leaves and refuses; the search itself is tested apart."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from verdicts import verdict

from thermo.app import _discover
from thermo.discover import Setting
from thermo.discover._memory import Memory
from thermo.mesh import box_mesh
from thermo.report import claimed

from .conftest import Command


def test_what_is_asked_is_handed_on_and_the_verdict_is_left(
    command: Command, block: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: dict[str, Any] = {}

    def search(scene: Any, **words: Any) -> Any:
        asked.update(words, scene=scene)
        words["say"]("meshing")
        return verdict("named")

    monkeypatch.setattr(_discover.discovery, "discover", search)
    out = tmp_path / "found"
    outcome = command(
        "discover", f"data={block}", f"out={out}", "runs=[lamp]", "unknown=[conductivity]",
        "initial.conductivity=1.5", "model_error=0.02", "candidates=[void,radiation]",
    )  # fmt: skip
    assert outcome.code == 0, outcome.err
    assert asked["runs"] == ("lamp",) and asked["unknown"] == ("conductivity",)
    assert asked["initial"] == {"conductivity": 1.5} and asked["model_error"] == 0.02
    assert asked["stepping"].most_frames == 300 and asked["scene"].object == "block"
    setting = Setting(box_mesh((0.02, 0.01, 0.01), (2, 1, 1)), 2700.0, 30.0, 290.0, 340.0)
    assert [one.card.name for one in asked["candidates"](setting)] == ["radiation", "void"]
    found = json.loads((out / "verdict.json").read_text())
    assert found["effects"] == ["hidden_source"] and found["object"] == "block"
    assert found["configuration"]["runs"] == ["lamp"] and found["seconds"] >= 0
    assert "Missing effect: hidden source" in outcome.out and "meshing" in outcome.err
    last = outcome.out.rstrip().splitlines()[-3:]
    assert [line.partition(": ")[0] for line in last] == [
        str(out / name) for name in ("verdict.json", "verdict.html", "estimate.npz")
    ]
    assert all(len(line.partition(": ")[2]) > 10 for line in last)
    assert (out / "verdict.html").stat().st_size > 1e6


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("runs=[nope]",), "nope"),
        (("unknown=[heaviness]",), "heaviness"),
        (("unknown=[conductivity,heater_power]",), "heater_power"),
        (("prior.decay=0.1",), "prior"),
        (("model_error=0",), "model_error"),
        (("candidates=[void,ghost]",), "ghost"),
        (("candidates=void",), "candidates"),
        (("runs=[test_lamp]",), "test_lamp"),
    ],
)
def test_bad_settings_are_refused_before_any_work(
    command: Command, block: Path, tmp_path: Path, words: tuple[str, ...], named: str
) -> None:
    out = tmp_path / "nothing"
    outcome = command("discover", f"data={block}", f"out={out}", *words)
    assert outcome.code == 2 and named in outcome.err and "remedy" in outcome.err.lower()
    assert "meshing" not in outcome.err and not (out / "verdict.json").exists()


def test_what_is_finished_stays_after_a_stop_and_goes_once_the_verdict_is_left(
    command: Command, block: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, asked, stops = tmp_path / "out", list[Path](), iter([True, False])

    def search(*_: Any, **words: Any) -> Any:
        asked.append(words["checkpoint"])
        Memory(words["checkpoint"]).recalled("fit", 1.5, lambda: [np.ones(3)])
        if next(stops):
            raise KeyboardInterrupt
        return verdict("named")

    monkeypatch.setattr(_discover.discovery, "discover", search)
    outcome = command("discover", f"data={block}", f"out={out}")
    assert outcome.code == 130 and "the same command goes on from what" in outcome.err
    assert [one.name for one in out.iterdir()] == ["progress"] and asked == [out / "progress"]
    outcome = command("discover", f"data={block}", f"out={out}")
    assert outcome.code == 0 and f"going on from {out / 'progress'}" in outcome.err
    assert sorted(one.name for one in out.iterdir()) == [
        "estimate.npz", "verdict.html", "verdict.json",
    ]  # fmt: skip


def test_two_searches_into_one_folder_are_kept_apart(
    command: Command, block: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_discover.discovery, "discover", lambda *_, **__: verdict("named"))
    out = tmp_path / "out"
    out.mkdir()
    with claimed(out):
        outcome = command("discover", f"data={block}", f"out={out}")
    assert outcome.code == 2 and "another process works in this folder" in outcome.err
    assert str(out) in outcome.err and list(out.iterdir()) == []
    assert command("discover", f"data={block}", f"out={out}").code == 0
