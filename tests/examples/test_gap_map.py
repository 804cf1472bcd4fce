"""The maps of a record of `thermo discover`."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import ModuleType

import pytest
from matplotlib import image
from scripts import load_example
from verdicts import verdict

from thermo.report import discovery_record, write_discovery


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    return load_example("gap_map", monkeypatch)


@pytest.mark.parametrize("kind", ["named", "no_gap", "none_of_mine", "inseparable"])
def test_each_run_has_a_row(
    kind: str, example: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = verdict(kind)
    write_discovery(tmp_path, found, discovery_record(found) | {"object": "plate"})
    monkeypatch.setattr(sys, "argv", ["gap_map", str(tmp_path)])
    example.main()
    runs = json.loads((tmp_path / "verdict.json").read_text("utf-8"))["residuals"]
    height, width = image.imread(tmp_path / "gap_map.png").shape[:2]
    assert width == pytest.approx(924, abs=1)
    assert height == pytest.approx(319 * len(runs), abs=1)


def test_a_folder_without_a_verdict_is_told_of(
    example: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["gap_map", str(tmp_path)])
    with pytest.raises(SystemExit, match=r"no .*verdict\.json"):
        example.main()
