"""The scene of the PMMA example, of made-up records; the search itself takes minutes."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scripts import load_example

from thermo import read_scene
from thermo.discover import Setting, library
from thermo.mesh import box_mesh


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    return load_example("capa_pmma", monkeypatch)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """Records of the format of the University of Maryland's, at two rates."""
    folder = tmp_path / "data" / "measured" / "umd_capa_pmma"
    folder.mkdir(parents=True)
    for flux, every, start in ((25, 0.93, 297.5), (60, 0.133, 309.3)):
        time = np.arange(0.0, 200.0, every)
        columns = [time, 0 * time, start + 0.2 * time, 0 * time, 0 * time + 1]
        rows = "\n".join(",".join(f"{x:.4f}" for x in row) for row in np.stack(columns, 1))
        header = "Time,MLR_mean,Temp_avg_all4,MLR_error,Temperature_Error\n[s],a,[K],a,[K]\n"
        (folder / f"UMD_CAPA_{flux}kW_Temp.csv").write_text(header + rows, encoding="utf-8")
    return tmp_path / "data"


def test_both_fluxes_stand_in_one_scene(example: ModuleType, data: Path, tmp_path: Path) -> None:
    example.write_slab(data, tmp_path / "scene")
    scene = read_scene(tmp_path / "scene")
    assert set(scene.runs) == {"flux_25", "flux_60"} and scene.unknown == ("conductivity",)
    expected = ((25, 150.0, 330.0, 300.0, 297.5), (60, 60.0, 365.0, 303.0, 309.3))
    for flux, end, gas, behind, start in expected:
        run = scene.runs[f"flux_{flux}"]
        assert run.initial_temperature == pytest.approx(start)
        record = run.recording
        assert record.time[-1] <= end < record.time[-1] + 2 and np.diff(record.time).max() < 1.1
        assert np.array_equal(record.points, np.zeros((1, 3)))
        assert run.heater is not None
        assert run.heater.power == pytest.approx(0.96e3 * flux * example.SIDE**2)
        (air,) = run.air
        assert (run.ambient_temperature, air.temperature) == (gas, behind)
        assert (scene.convection, air.convection) == (8.6, 4.0)


def test_a_latent_heat_alone_is_not_looked_for(example: ModuleType) -> None:
    setting = Setting(box_mesh((0.02, 0.01, 0.01), (2, 1, 1)), 1210.0, 0.2, 290.0, 560.0)
    kept = [one.card.name for one in example.CANDIDATES(setting)]
    every = [one.card.name for one in library(setting)]
    assert set(every) - set(kept) == {"latent_heat"} and len(kept) == len(every) - 1


def test_a_missing_record_is_told_of(example: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="THERMOFIELD_DATA"):
        example.write_slab(tmp_path, tmp_path / "scene")
