"""Light that goes along a wall does not fall on it, however the mesh's faces tilt."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from thermo.mesh import Sizing, Surface, tetrahedralise
from thermo.physics import discretise
from thermo.physics.effects import spot_profile

UP = np.array([0.0, 0.0, 1.0])


def test_a_lamp_below_a_cylinder_leaves_its_side_dark(tmp_path: Path) -> None:
    shape = trimesh.creation.cylinder(radius=0.02, height=0.03, sections=48)
    surface = Surface(np.asarray(shape.vertices, float), np.asarray(shape.faces, np.int64))
    space = discretise(tetrahedralise(surface, Sizing(0.005, 0.008, 0.01), cache=tmp_path))
    profile = spot_profile(space, centre=np.zeros(3), direction=UP, radius=0.015)
    each = (profile * np.asarray(space.face_weight)).sum(axis=1)
    a, b, c = (space.mesh.nodes[space.mesh.faces[:, i]] for i in range(3))
    own = np.cross(b - a, c - a)
    along = (own @ UP) / np.linalg.norm(own, axis=1)
    side = np.abs(along) < 0.5
    assert each[side].max() < 1e-12 and np.isclose(each.sum(), 1.0)
    assert along[side].min() < -1e-4, "by its own inclination a part of it would be lit"
