"""What the examples that ask for a missing effect print and leave."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest
from matplotlib import image
from scripts import load_example
from verdicts import verdict

from thermo.discover import Setting, library
from thermo.mesh import box_mesh
from thermo.report import discovery_record


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    return load_example("asking", monkeypatch)


def test_it_tells_each_round_and_leaves_the_page(
    example: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = verdict("inseparable")
    example.tell(found, "a plate & its lamp", tmp_path)
    lines = capsys.readouterr().out.splitlines()
    assert lines[:4] == [
        "round 1: hidden_source or sensor_lag, 1.25 W [1.21, 1.29]",
        "  lamp: rms 0.500 to 0.050 K",
        "  cooling: rms 0.200 to 0.060 K",
        "conductivity: 2.2 before, 2 after",
    ]
    assert lines[4:-2] == discovery_record(found)["sentences"] and len(lines) > 6
    assert lines[-2:] == [
        f"page: {tmp_path / 'verdict.html'}", f"picture: {tmp_path / 'curves.png'}",
    ]  # fmt: skip
    assert "a plate &amp; its lamp" in (tmp_path / "verdict.html").read_text("utf-8")


@pytest.mark.parametrize("kind", ["named", "no_gap"])
def test_the_picture_sets_the_model_with_what_was_found_beside_that_without(
    kind: str, example: ModuleType, tmp_path: Path
) -> None:
    found = verdict(kind)
    example.draw(found, "a plate", tmp_path / "curves.png")
    height, width = image.imread(tmp_path / "curves.png").shape[:2]
    columns = 2 if found.additions else 1
    assert (columns == 2) == (kind == "named")
    rows = len(found.stated.runs)
    assert width == pytest.approx(572 * columns, abs=1)
    assert height == pytest.approx(396 * rows, abs=1)


def test_couples_are_no_camera(example: ModuleType) -> None:
    setting = Setting(box_mesh((0.02, 0.01, 0.01), (2, 1, 1)), 2700.0, 30.0, 290.0, 340.0)
    kept, every = (
        [one.card.name for one in some(setting)]
        for some in (example.without(*example.CAMERA), library)
    )
    assert set(every) - set(kept) == {"camera_emissivity", "camera_drift"}
    assert kept == [name for name in every if name in kept]
