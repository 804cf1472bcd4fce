"""`thermo discover`: what it asks for, leaves and refuses; the search itself is tested apart."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from verdicts import verdict

from thermo.app import _discover

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
        "initial.conductivity=1.5", "model_error=0.02",
    )  # fmt: skip
    assert outcome.code == 0, outcome.err
    assert asked["runs"] == ("lamp",) and asked["unknown"] == ("conductivity",)
    assert asked["initial"] == {"conductivity": 1.5} and asked["model_error"] == 0.02
    assert asked["stepping"].most_frames == 300 and asked["scene"].object == "block"
    found = json.loads((out / "verdict.json").read_text())
    assert found["effects"] == ["hidden_source"] and found["object"] == "block"
    assert found["configuration"]["runs"] == ["lamp"] and found["seconds"] >= 0
    assert "Missing effect: hidden source" in outcome.out and "meshing" in outcome.err
    assert outcome.out.rstrip().endswith(f"{out}: verdict.json, verdict.html, estimate.npz")
    assert (out / "verdict.html").stat().st_size > 1e6


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("runs=[nope]",), "nope"),
        (("unknown=[heaviness]",), "heaviness"),
        (("model_error=0",), "model_error"),
        (("runs=[test_lamp]",), "test_lamp"),
    ],
)
def test_bad_settings_are_refused_before_any_work(
    command: Command, block: Path, tmp_path: Path, words: tuple[str, ...], named: str
) -> None:
    out = tmp_path / "nothing"
    outcome = command("discover", f"data={block}", f"out={out}", *words)
    assert outcome.code == 2 and named in outcome.err and "remedy" in outcome.err.lower()
    assert not (out / "verdict.json").exists()


def test_a_stopped_search_does_not_promise_to_go_on(
    command: Command, block: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: Any, **__: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(_discover.discovery, "discover", stop)
    outcome = command("discover", f"data={block}", f"out={tmp_path / 'out'}")
    assert outcome.code == 130 and "the same command begins anew" in outcome.err
