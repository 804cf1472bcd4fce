"""The scenes of the rods, of made-up records; the search itself takes minutes."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scripts import load_example

from thermo import read_scene


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    return load_example("rod_losses", monkeypatch)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """Records of the laboratory's format, rows without readings among them."""
    folder = tmp_path / "data" / "measured" / "cu_boulder_rods"
    folder.mkdir(parents=True)
    time = np.arange(0.0, 600.0, 10.0)
    couples = 18 + np.arange(1, 9) * (0.2 + time[:, None] / 600)
    lines = ["Time (sec)\t" + "\t".join(f"TC {n}" for n in range(1, 9)) + "\t\t10/11/2019\t"]
    for when, row in zip(time, couples, strict=True):
        lines.append(f"{when:g}\t" + "\t".join(f"{one:.1f}" for one in row) + "\t\t\t")
    lines.insert(30, "295\t\t\t\t\t\t\t\t\t\t\t")
    for name in ("2019_Steel_20V_185mA.txt", "2019_Brass_30V_285mA.txt"):
        (folder / name).write_text("\r\n".join(lines), encoding="utf-8")
    return tmp_path / "data"


def test_a_rod_is_said_to_lose_nothing_and_its_couples_to_be_off(
    example: ModuleType, data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: dict[str, object] = {}
    monkeypatch.setattr(example, "discover", lambda folder, **more: asked.update(folder=folder))
    example.run("brass", data, tmp_path / "out", lambda _: None)
    assert asked["folder"] == tmp_path / "out" / "scene"
    scene = read_scene(tmp_path / "out" / "scene")
    assert scene.unknown == ("diffusivity",) and scene.convection == scene.emissivity == 0.0
    assert scene.material.conductivity == 115.0 and scene.object == "C360 rod"
    run = scene.runs["heating"]
    assert run.constant_error == 0.3 and len(run.prescribed) == 2
    assert run.recording.temperature.shape == (60, 6)
    assert run.recording.temperature[0, 0] == pytest.approx(273.15 + 18.4)


def test_a_missing_record_is_told_of(example: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="THERMOFIELD_DATA"):
        example.run("steel", tmp_path, tmp_path / "out")
