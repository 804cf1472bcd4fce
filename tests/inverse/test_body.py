"""The mesh of a scan: made fast, and close to the surface where it has to be."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from thermo.errors import InputError
from thermo.inverse import Meshing, _body
from thermo.mesh import Mesh, Surface, box_mesh

SIZE = (0.06, 0.04, 0.0015)  # m, a sheet


def sheet() -> Surface:
    made = trimesh.creation.box(SIZE)
    return Surface(np.asarray(made.vertices, float), np.asarray(made.faces))


def test_the_mesh_of_a_scan_fills_a_thin_sheet(tmp_path: Path) -> None:
    mesh = _body._scan_mesh(sheet(), Meshing(cache=tmp_path))
    assert mesh.volume() == pytest.approx(np.prod(SIZE), rel=5e-3)
    assert len(mesh.nodes) < 3000
    assert len(list(tmp_path.glob("*.npz"))) == 1, "the first one did"


def test_a_surface_that_a_loose_mesh_does_not_fill_gets_a_close_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked: list[float | None] = []

    def refused(surface: Surface, sizing: Any, **given: Any) -> Mesh:
        asked.append(sizing.tolerance)
        if sizing.tolerance is None:
            return box_mesh(SIZE, (3, 2, 1))
        raise InputError("no", where="x", value="y", limit="z", remedy="w")

    monkeypatch.setattr(_body, "tetrahedralise", refused)
    assert len(_body._scan_mesh(sheet(), Meshing(cache=tmp_path)).cells) > 0
    loose, close = asked
    # No looser than a twentieth of how thick the sheet is, nor closer than meshes are as a rule.
    usual = 5e-4 * float(np.linalg.norm(SIZE))
    assert loose == pytest.approx(max(0.05 * SIZE[2], usual), rel=0.1)
    assert close is None
