from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.mesh import Surface, in_beam

BALL = trimesh.creation.icosphere(subdivisions=3)
SURFACE = Surface(np.asarray(BALL.vertices, float), np.asarray(BALL.faces))


def unit(values: tuple[float, ...]) -> np.ndarray:
    vector = np.array(values)
    return vector / np.linalg.norm(vector)


@settings(max_examples=60, deadline=None)
@given(
    aim=st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda one: np.linalg.norm(one) > 0.1),
    aside=st.tuples(*[st.floats(-0.4, 0.4)] * 3),
    radius=st.floats(1e-3, 0.3),
)
def test_a_beam_meets_a_ball_once_where_it_comes_in(
    aim: tuple[float, ...], aside: tuple[float, ...], radius: float
) -> None:
    direction, centre = unit(aim), np.array(aside)
    points = in_beam(SURFACE, centre, direction, radius)
    away = points - centre
    across = away - np.outer(away @ direction, direction)
    assert (np.linalg.norm(across, axis=1) <= radius * (1 + 1e-9)).all()
    # On facets, which lie a little within the sphere, and turned to the light.
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0, atol=0.01)
    assert (points @ direction < 0.15).all()
    beside = np.linalg.norm(np.cross(centre, direction)) + radius
    if beside < 0.95:
        # A ray along an edge may meet the triangles on both of its sides.
        assert 61 <= len(points) and len(np.unique(points.round(9), axis=0)) == 61


def test_a_wide_face_of_two_triangles_is_met_where_the_beam_is() -> None:
    box = trimesh.creation.box([2.0, 2.0, 1.0])
    surface = Surface(np.asarray(box.vertices, float), np.asarray(box.faces))
    points = in_beam(surface, np.array([0.3, -0.2, 9.0]), np.array([0.0, 0.0, -1.0]), 0.01)
    np.testing.assert_allclose(points.mean(axis=0), [0.3, -0.2, 0.5], atol=1e-12)
    assert np.ptp(points[:, 0]) == pytest.approx(0.02)


def test_a_beam_that_passes_meets_nothing() -> None:
    direction = np.array([1.0, 0.0, 0.0])
    assert in_beam(SURFACE, np.array([0.0, 0.0, 1.2]), direction, 0.1).shape == (0, 3)
