"""Surfaces that are too fine for the mesher."""

import numpy as np
import pytest
import trimesh

from thermo.errors import InputError
from thermo.mesh import Sizing, Surface, tetrahedralise
from thermo.mesh import _simplify as module
from thermo.mesh import _tetrahedralise as mesher

SIZING = Sizing(0.01, 0.01, 0.01)


def test_a_moderate_surface_is_left_alone(cube):
    assert module.simplified(cube, most=192, target=80, where="cube") is cube


def test_without_the_package_a_fine_surface_is_refused_at_once(cube, tmp_path, monkeypatch):
    monkeypatch.setattr(mesher, "MOST_TRIANGLES", 100)
    monkeypatch.setattr(module, "find_spec", lambda _: None)
    monkeypatch.setattr(mesher, "_run_mesher", lambda *_: pytest.fail("the mesher ran"))
    with pytest.raises(InputError, match="192 triangles") as refusal:
        tetrahedralise(cube, SIZING, cache=tmp_path, where="cube.stl")
    assert "cube.stl" in str(refusal.value) and "libigl" in str(refusal.value)


def test_a_ball_keeps_its_volume():
    shape = trimesh.creation.icosphere(subdivisions=4, radius=0.025)
    fine = Surface(np.asarray(shape.vertices, float), np.asarray(shape.faces, np.int64))
    less = module.simplified(fine, most=1000, target=1000, where="ball")
    assert len(less.triangles) == 1000
    # Vertices that stay on the ball would leave 0.7 % less.
    assert less.volume() == pytest.approx(fine.volume(), rel=0.005)


def test_its_result_is_checked(ball, monkeypatch):
    coarse = trimesh.creation.icosphere(subdivisions=1, radius=0.025)
    faces = coarse.faces[:60]
    monkeypatch.setattr("igl.qslim", lambda *_: (coarse.vertices, faces, None, None))
    with pytest.raises(InputError, match="simplified"):
        module.simplified(ball, most=100, target=80, where="ball")
