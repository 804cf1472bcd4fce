"""How much of a surface cameras read."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from cameras import camera_at

from thermo.imaging import coverage, looks_of
from thermo.mesh import Surface

RADIUS = 0.05
MESH = trimesh.creation.icosphere(subdivisions=4, radius=RADIUS)
BALL = Surface(np.asarray(MESH.vertices), np.asarray(MESH.faces, dtype=np.int64))


def test_a_camera_reads_the_cap_within_the_grazing_angle() -> None:
    camera = camera_at((0.5, 0.0, 0.0), size=(160, 120), focal=500.0)
    share = coverage(looks_of(BALL, [camera], grazing=50.0, margin=1))
    # The angle at the ball's centre is that to the normal less that at the eye.
    polar = np.radians(50.0) - np.arcsin(RADIUS / 0.5 * np.sin(np.radians(50.0)))
    assert share == pytest.approx((1 - np.cos(polar)) / 2, abs=0.02)


def test_a_second_camera_on_the_other_side_doubles_it() -> None:
    first = camera_at((0.5, 0.0, 0.0), size=(160, 120), focal=500.0)
    other = camera_at((-0.5, 0.0, 0.0), size=(160, 120), focal=500.0)
    one, both = (coverage(looks_of(BALL, seen)) for seen in ([first], [first, other]))
    assert both == pytest.approx(2 * one, abs=0.04) and one > 0.2
