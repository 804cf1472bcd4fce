"""Smaller triangles of the same surface."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from cameras import camera_at

from thermo.errors import InputError
from thermo.imaging import look, refined
from thermo.mesh import Surface


def plate() -> Surface:
    box = trimesh.creation.box([0.1, 0.004, 0.06])
    return Surface(np.asarray(box.vertices), np.asarray(box.faces, dtype=np.int64))


def test_no_edge_is_longer_and_the_body_is_the_same() -> None:
    whole = plate()
    fine = refined(whole, 0.005)
    corners = fine.vertices[fine.triangles]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert edges.max() <= 0.005 and len(fine.triangles) > 50 * len(whole.triangles)
    assert fine.volume() == pytest.approx(whole.volume(), rel=1e-12)
    assert fine.area() == pytest.approx(whole.area(), rel=1e-12)


def test_no_ray_slips_through_where_large_and_small_meet() -> None:
    camera = camera_at((0.05, -0.2, 0.08), size=(120, 90), focal=150.0)
    before, after = look(camera, plate()), look(camera, refined(plate(), 0.003))
    assert np.array_equal(before.triangle >= 0, after.triangle >= 0)
    np.testing.assert_allclose(before.depth, after.depth, atol=1e-9)


def test_a_length_that_makes_no_sense_is_refused() -> None:
    with pytest.raises(InputError, match="length of an edge"):
        refined(plate(), 0.0)
