"""Surfaces that are too fine for the mesher."""

import numpy as np
import pytest
import trimesh

from thermo.errors import InputError
from thermo.mesh import Sizing, tetrahedralise
from thermo.mesh import _simplify as module
from thermo.mesh import _tetrahedralise as mesher

SIZING = Sizing(0.01, 0.01, 0.01)


def test_a_moderate_surface_is_left_alone(cube):
    assert module.simplified(cube, where="cube") is cube


def test_without_the_package_a_fine_surface_is_refused_at_once(cube, tmp_path, monkeypatch):
    monkeypatch.setattr(module, "MOST_TRIANGLES", 100)
    monkeypatch.setattr(module, "find_spec", lambda _: None)
    monkeypatch.setattr(mesher, "_run_mesher", lambda *_: pytest.fail("the mesher ran"))
    with pytest.raises(InputError, match="192 triangles") as refusal:
        tetrahedralise(cube, SIZING, cache=tmp_path, where="cube.stl")
    assert "cube.stl" in str(refusal.value) and "fast-simplification" in str(refusal.value)


def test_with_the_package_its_result_is_checked(ball, monkeypatch):
    monkeypatch.setattr(module, "MOST_TRIANGLES", 100)
    monkeypatch.setattr(module, "find_spec", lambda _: True)
    coarse = trimesh.creation.icosphere(subdivisions=1, radius=0.025)
    monkeypatch.setattr(
        trimesh.Trimesh, "simplify_quadric_decimation", lambda _, face_count: coarse
    )
    less = module.simplified(ball, where="ball")
    assert len(less.triangles) == 80 and np.ptp(less.vertices) <= 0.0501
    torn = trimesh.Trimesh(coarse.vertices, coarse.faces[:60], process=False)
    monkeypatch.setattr(trimesh.Trimesh, "simplify_quadric_decimation", lambda _, face_count: torn)
    with pytest.raises(InputError, match="simplified"):
        module.simplified(ball, where="ball")
