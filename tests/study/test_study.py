"""A study goes through its cases and leaves tables and figures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from thermo.report import write_npz
from thermo.study import PRESETS, ROWS, Case, study
from thermo.study import _study as module

from .records import made, repeated

BALL = trimesh.creation.icosphere(subdivisions=2, radius=0.03)


def leave_maps(path: Path, test: str = "heating") -> None:
    """What a fit of a ball leaves for the figure."""
    some = np.asarray(BALL.vertices)[::5]
    errors = np.linspace(0.0, 0.1, len(some))
    held_out = {f"points_{test}": some, f"error_{test}": errors}
    ratio = np.linspace(0.99, 1.02, len(BALL.faces))
    write_npz(path, nodes=BALL.vertices, faces=BALL.faces, ratio=ratio, areas=BALL.area_faces,
              points=some, fitted=errors, **held_out)  # fmt: skip


def run(tmp_path: Path, records: list, monkeypatch: pytest.MonkeyPatch) -> tuple[list, list[int]]:
    left, told = iter(records), []
    monkeypatch.setattr(module, "study_case", lambda *_: next(left))
    case = Case(ROWS["car-heating"], "best", PRESETS["best"], tmp_path, False, False)
    got, _ = study([case] * len(records), tmp_path, on_case=told.append)
    return got, told


def test_records_tables_and_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    records = [made("bunny-cooling"), made("car-heating"), *repeated("car-cooling")]
    leave_maps(tmp_path / "bunny-cooling-best-none-maps.npz")
    leave_maps(tmp_path / "car-heating-best-none-maps.npz", test="warming")
    # Of a fit that this study did not make, and without any test.
    leave_maps(tmp_path / "bear-cooling-best-none-maps.npz")
    got, told = run(tmp_path, records, monkeypatch)
    assert got == records and told == [1, 2, 3, 4, 5, 6]
    names = {file.name for file in tmp_path.iterdir()}
    assert {"recovery.csv", "ensembles.csv", "tables.md"} <= names
    assert {name for name in names if name.endswith(".png")} == {
        "robustness-best-none.png", "transfer-best-none.png",
    }  # fmt: skip


def test_nothing_is_drawn_of_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    leave_maps(tmp_path / "bunny-cooling-best-none-maps.npz", test="freezing")
    run(tmp_path, [made("bunny-cooling"), made("cube-heating")], monkeypatch)
    assert not list(tmp_path.glob("*.png"))
