"""Estimates: numbers over the surface, the file that carries them, and damaged files."""

from __future__ import annotations

import stat
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.inverse import (
    Estimate,
    RecoveredField,
    RunFit,
    load_estimate,
    save_estimate,
    summary,
    surface_values,
    weighted_quantile,
)
from thermo.inverse._properties import Stated
from thermo.mesh import face_areas

from .objectives import MESH


def recovered(name: str = "conductivity", unit: str = "W/m/K") -> RecoveredField:
    cells, faces = len(MESH.cells), len(MESH.faces)
    return RecoveredField(name, unit, np.linspace(0.5, 1.5, cells), np.linspace(1, 2, faces))


def estimate() -> Estimate:
    fields = {"conductivity": recovered(), "emissivity": recovered("emissivity", "1")}
    stated = Stated(0.8, 1.54e6, 25.0, 0.6)
    return Estimate(MESH, 2, stated, fields, {}, [[2.0, 1.0]], True, 1.0, "fine", {})


def test_what_is_saved_is_loaded(tmp_path: Path) -> None:
    file = tmp_path / "estimate.npz"
    save_estimate(file, estimate())
    mesh, order, stated, fields = load_estimate(file)
    for part in ("nodes", "cells", "faces", "owners", "normals"):
        assert np.array_equal(getattr(mesh, part), getattr(MESH, part)), part
    assert order == 2 and stated == estimate().stated
    assert list(fields) == ["conductivity", "emissivity"]
    for name, field in estimate().fields.items():
        assert (fields[name].name, fields[name].unit) == (name, field.unit)
        assert np.array_equal(fields[name].cells, field.cells)
        assert np.array_equal(fields[name].faces, field.faces)
    assert [path.name for path in tmp_path.iterdir()] == ["estimate.npz"]


def test_it_shows_itself_in_a_line_not_in_pages_of_arrays() -> None:
    words = repr(estimate())
    assert "success=True" in words and "array" not in words and len(words) < 400


def damage(file: Path, kind: str) -> None:
    save_estimate(file, estimate())
    data = file.read_bytes()
    with np.load(file, allow_pickle=False) as stored:
        arrays = dict(stored)
    if kind == "missing":
        file.unlink()
    elif kind == "truncated":
        file.write_bytes(data[: len(data) // 2])
    elif kind == "flipped":
        place = data.index(b"nodes.npy") + 60
        file.write_bytes(data[:place] + bytes([data[place] ^ 255]) + data[place + 1 :])
    elif kind == "text":
        file.write_text("no archive")
    elif kind == "pickled":
        arrays["stated"] = np.array([{"conductivity": 1.0}], dtype=object)
        np.savez(file, **arrays)  # type: ignore[arg-type]
    elif kind == "other format":
        np.savez(file, allow_pickle=False, **{**arrays, "format": np.asarray("other/9")})
    elif kind == "other faces":
        np.savez(file, allow_pickle=False, **{**arrays, "faces": arrays["faces"][::-1]})
    elif kind == "lacking":
        del arrays["faces_conductivity"]
        np.savez(file, allow_pickle=False, **arrays)


KINDS = [
    "missing", "truncated", "flipped", "text", "pickled", "other format", "other faces", "lacking"
]  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_estimate_is_refused(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "estimate.npz"
    damage(file, kind)
    with pytest.raises(InputError, match="this estimate cannot be read") as caught:
        load_estimate(file)
    assert caught.value.where == str(file)
    assert (caught.value.value == "no such file") is (kind == "missing")
    assert "thermofield-estimate/1" in caught.value.limit and "invert" in caught.value.remedy


def test_a_failed_write_leaves_the_older_estimate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "estimate.npz"
    save_estimate(file, estimate())
    before = file.read_bytes()

    def full(name: str, **_: object) -> None:
        Path(name).write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    with pytest.raises(InputError, match="cannot be written") as caught:
        save_estimate(file, estimate())
    assert caught.value.where == str(file) and "No space" in str(caught.value.value)
    assert file.read_bytes() == before and len(list(tmp_path.iterdir())) == 1


@given(
    values=st.lists(st.integers(-1000, 1000), min_size=1, max_size=12),
    times=st.integers(1, 4),
    share=st.floats(0, 1),
)
def test_quantiles_stay_within_the_values_and_ignore_the_unit_of_area(
    values: list[int], times: int, share: float
) -> None:
    array = np.array(values, float)
    areas = np.linspace(1.0, 2.0, len(array))
    found = weighted_quantile(array, areas, share)
    assert array.min() <= found <= array.max()
    assert found == pytest.approx(weighted_quantile(array, areas * times, share), abs=1e-9)


def test_the_median_is_weighted_by_area() -> None:
    values = np.array([3.0, 1.0, 2.0])
    assert weighted_quantile(values, np.ones(3), 0.5) == 2.0
    assert weighted_quantile(values, np.array([100.0, 1.0, 1.0]), 0.5) == pytest.approx(3, abs=0.05)
    assert weighted_quantile(values, np.array([1.0, 100.0, 1.0]), 0.5) == pytest.approx(1, abs=0.05)


def test_the_summary_names_unit_and_quantiles() -> None:
    field, areas = recovered(), face_areas(MESH)
    assert summary(MESH, field) == {
        "unit": "W/m/K",
        "median": weighted_quantile(field.faces, areas, 0.5),
        "p05": weighted_quantile(field.faces, areas, 0.05),
        "p95": weighted_quantile(field.faces, areas, 0.95),
    }


def test_a_vertex_takes_the_area_weighted_mean_of_its_faces() -> None:
    field, areas = recovered(), face_areas(MESH)
    points, values = surface_values(MESH, field)
    assert len(points) == len(np.unique(MESH.faces)) == len(values)
    for point, value in zip(points[::5], values[::5], strict=True):
        node = np.flatnonzero((MESH.nodes == point).all(1))
        around = (MESH.faces == node[0]).any(1)
        wanted = (field.faces[around] * areas[around]).sum() / areas[around].sum()
        assert value == pytest.approx(wanted, rel=1e-12)


def test_others_may_read_the_file(tmp_path: Path) -> None:
    file, plain = tmp_path / "estimate.npz", tmp_path / "plain"
    save_estimate(file, estimate())
    plain.touch()
    assert stat.S_IMODE(file.stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)


def test_the_error_at_the_end_is_that_of_the_last_frame_with_readings() -> None:
    measured = np.array([[300.0, 300.0, 300.0], [301.0, 302.0, np.nan], [np.nan] * 3])
    simulated = np.array([[309.0, 309.0, 309.0], [301.5, 301.0, 350.0], [400.0] * 3])
    run = RunFit(1.0, 0.1, 0.0, 0.1, np.arange(3.0), np.zeros((3, 3)), measured, simulated)
    assert run.final_mae() == pytest.approx(0.75)
