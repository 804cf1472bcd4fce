"""Projection of a camera, and its inverse."""

from __future__ import annotations

import numpy as np
import pytest
from cameras import camera_at
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging import Camera, pixel_centres, project, rays

BENT = (-0.31, 0.12, 0.002, -0.003, 0.02)


def test_projection_is_the_paper_s() -> None:
    camera = Camera(640, 480, (500.0, 510.0), (320.0, 240.0), np.eye(4))
    pixels, depth = project(camera, np.array([[0.1, -0.2, 2.0], [0.0, 0.0, -1.0]]))
    np.testing.assert_allclose(pixels[0], [500 * 0.05 + 320, -510 * 0.1 + 240])
    assert depth[0] == 2.0 and np.isnan(pixels[1]).all()


@given(
    st.tuples(*[st.floats(-0.1, 0.1)] * 3),
    st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(0.1, 1)),
    st.sampled_from([(0.0,) * 5, BENT]),
)
def test_a_line_of_sight_meets_its_point(point: tuple, place: tuple, bends: tuple) -> None:
    far = np.array(place) / np.linalg.norm(place) * 0.8
    if np.hypot(far[0], far[1]) < 1e-3:
        return
    camera = camera_at(tuple(far), bends=bends)
    points = np.array([point])
    pixels, depth = project(camera, points)
    away = points - camera.place()
    np.testing.assert_allclose(rays(camera, pixels), away / np.linalg.norm(away), atol=1e-12)
    again, _ = project(camera, camera.place() + rays(camera, pixels) * 0.3)
    assert np.abs(again - pixels).max() < 1e-9
    assert depth[0] == pytest.approx(away[0] @ camera.pose[2, :3])


def test_pixels_count_columns_first() -> None:
    camera = camera_at((1.0, 0.0, 0.0), size=(3, 2))
    assert pixel_centres(camera).tolist() == [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]
    np.testing.assert_allclose(camera.place(), [1.0, 0.0, 0.0], atol=1e-12)


def test_no_point_is_seen_where_the_lens_folds() -> None:
    # r (1 + k r^2) with k = -1 turns back at r = 0.58, where it reaches 0.385.
    camera = camera_at((1.0, 0.0, 0.0), bends=(-1.0, 0.0, 0.0, 0.0, 0.0))
    seen = rays(camera, camera.centre + np.array([[0.38 * 80, 0.0], [0.39 * 80, 0.0]]))
    assert np.isfinite(seen[0]).all() and np.isnan(seen[1]).all()


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"width": 0}, "no such size"),
        ({"height": -3}, "no such size"),
        ({"focal": (0.0, 1.0)}, "focal length"),
        ({"centre": [1.0, np.nan]}, "principal point"),
        ({"distortion": [0.1, 0.2]}, "5 finite numbers"),
        ({"pose": np.diag([3.0, 3.0, 3.0, 1.0])}, "axes of length 3"),
    ],
)
def test_what_is_no_camera_is_refused(wrong: dict, words: str) -> None:
    fine = {"width": 4, "height": 3, "focal": (5.0, 5.0), "centre": (1.0, 1.0), "pose": np.eye(4)}
    with pytest.raises(InputError, match=words):
        Camera(**(fine | wrong), where="cam.json")
