"""The scenes of the gasification example, of made-up records; the search itself takes minutes."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scripts import load_example

from thermo import read_scene
from thermo.discover import Setting, library
from thermo.inverse._conditions import conditions
from thermo.mesh import box_mesh
from thermo.physics import discretise

SIDE = 4e-3


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    return load_example("nist_gasification", monkeypatch)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """Records of the format of NIST's."""
    folder = tmp_path / "data" / "measured" / "nist_gasification"
    folder.mkdir(parents=True)
    time = np.arange(0.0, 30.0)
    for name, couples in (("Black-Copper_q50_Temp.csv", 1), ("Black-Insulation_q50_Temp.csv", 3)):
        columns = [
            time,
            *(295.0 + (k + 1) * time for k in range(couples)),
            *[0 * time + 2] * couples,
        ]
        rows = "\n".join(",".join(f"{x:.4f}" for x in row) for row in np.stack(columns, 1))
        (folder / name).write_text(f"Time,Temperature\n[s],[K]\n{rows}\n", encoding="utf-8")
    return tmp_path / "data"


def test_what_is_known_to_be_absent_is_not_looked_for(example: ModuleType) -> None:
    setting = Setting(box_mesh((0.02, 0.01, 0.01), (2, 1, 1)), 8940.0, 390.0, 290.0, 640.0)
    every = {one.card.name for one in library(setting)}
    absent = {"camera_emissivity", "camera_drift"}
    for case, left_out in (("copper", absent | {"latent_heat"}), ("insulation", absent)):
        kept = {one.card.name for one in example.CANDIDATES[case](setting)}
        assert every - kept == left_out


def test_copper_takes_in_the_panel_s_flux_and_loses_nothing(
    example: ModuleType, data: Path, tmp_path: Path
) -> None:
    error, end = example.copper(data, tmp_path / "scene")
    assert (error, end) == (1.0, 29.0)
    run = read_scene(tmp_path / "scene").runs["panel"]
    height = example.PLATE
    mesh = box_mesh((SIDE, SIDE, height), (2, 2, 2))
    space = discretise(mesh)
    under = conditions(run, space)
    # The box of the test begins at a corner, the example's at its middle; both are as wide.
    assert float(under.power) == pytest.approx(0.92 * 50e3 * SIDE**2)
    top = np.asarray(space.mesh.normals)[:, 2] > 0.5
    assert np.array_equal(np.asarray(under.exposed) > 0, top)
    share = [float(under.schedule.share(time)) for time in (5.0, 30.0, 100.0, 500.0)]
    assert share == pytest.approx([0.9401, 0.9598, 0.9831, 1.0])


def test_insulation_is_held_at_both_ends_and_exchanges_nowhere(
    example: ModuleType, data: Path, tmp_path: Path
) -> None:
    error, _ = example.insulation(data, tmp_path / "scene")
    # One of the middle couple, and half of one of each of the others.
    assert error == pytest.approx(np.sqrt(1 + 2 / 4))
    scene = read_scene(tmp_path / "scene")
    run, height = scene.runs["panel"], 2 * example.LAYER
    above, below = run.prescribed
    assert above.temperature[-1] == 295.0 + 29.0 and below.temperature[-1] == 295.0 + 3 * 29.0
    assert run.recording.temperature[-1, 0] == 295.0 + 2 * 29.0
    space = discretise(box_mesh((SIDE, SIDE, height), (2, 2, 4)))
    under = conditions(run, space)
    ends = np.abs(np.asarray(space.mesh.normals)[:, 2]) > 0.5
    assert np.array_equal(np.asarray(under.exposed) > 0, ends)
    assert under.prescribed is not None
    held = np.asarray(under.prescribed.patch)
    assert np.array_equal(held >= 0, np.isin(space.mesh.nodes[:, 2], [0.0, height]))


def test_where_the_records_are_not_it_says_what_to_do(
    example: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["nist_gasification.py", "copper", str(tmp_path / "no")])
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit, match="THERMOFIELD_DATA"):
        example.main()
