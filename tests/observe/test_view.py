"""What a camera sees: the near side, as dense as its pixels, and nothing behind something else."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.mesh import Surface
from thermo.observe import seen_from


def surface(*parts: trimesh.Trimesh) -> Surface:
    body = trimesh.util.concatenate(list(parts))
    return Surface(np.asarray(body.vertices), np.asarray(body.faces))


@given(azimuth=st.floats(0, 6.28), height=st.floats(-1, 1), seed=st.integers(0, 99))
def test_of_a_ball_the_near_cap_is_seen(azimuth: float, height: float, seed: int) -> None:
    ball = surface(trimesh.creation.icosphere(subdivisions=3, radius=0.02))
    flat = np.sqrt(1 - height**2)
    camera = 0.06 * np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), height])
    points = seen_from(ball, camera, 60, seed=seed)
    assert points.shape == (60, 3)
    assert np.allclose(np.linalg.norm(points, axis=1), 0.02, rtol=0.02)
    # The rim of what is seen lies where a tangent meets the ball: cos = radius / distance; a flat
    # triangle that crosses it is up to 0.15 long.
    assert (points @ camera).min() > 0.02 * 0.06 * (1 / 3 - 0.1)


def test_pixels_are_as_dense_as_cosine_over_square_of_distance() -> None:
    board = surface(trimesh.creation.box(extents=(1.0, 1.0, 0.01)))
    camera = np.array([0.0, 0.0, 0.505])
    points = seen_from(board, camera, 4000, seed=1)
    assert np.allclose(points[:, 2], 0.005)
    # In its picture the points fill the board's square evenly.
    picture = points[:, :2] / (camera[2] - points[:, 2])[:, None]
    inner = np.hypot(*picture.T)
    share = np.mean(inner < 0.5) / np.mean(inner < 1.0)
    # Solid angle within a cone of half-angle atan(t): 2 pi (1 - 1 / sqrt(1 + t^2)).
    cone = [1 - 1 / np.sqrt(1 + t**2) for t in (0.5, 1.0)]
    assert share == pytest.approx(cone[0] / cone[1], abs=0.04)


def test_what_stands_behind_something_else_is_not_seen() -> None:
    board = trimesh.creation.box(extents=(0.1, 0.1, 0.01))
    block = trimesh.creation.box(extents=(0.04, 0.04, 0.01))
    block.apply_translation([0, 0, 0.05])
    points = seen_from(surface(board, block), np.array([0.0, 0.0, 0.155]), 500)
    on_board = points[:, 2] < 0.01
    assert 100 < on_board.sum() < 400
    # The shadow of a block 0.1 away, of half-width 0.02, on a board at 0.15.
    assert np.abs(points[on_board, :2]).max(axis=1).min() > 0.0295


@pytest.mark.parametrize("camera", [(0.0, 0.0, 0.0), (0.001, 0.0, 0.002)])
def test_a_camera_inside_is_refused(camera: tuple[float, float, float]) -> None:
    with pytest.raises(InputError) as caught:
        seen_from(surface(trimesh.creation.box(extents=(0.1,) * 3)), np.array(camera), 10)
    assert caught.value.where == "camera" and "m" in caught.value.limit


def test_a_camera_inside_sees_nothing_through_the_walls() -> None:
    # Of a bent body the inner side of the other arm turns its front to a place within this one.
    around = np.array([(0, 0), (0.1, 0), (0.1, 0.02), (0.02, 0.02), (0.02, 0.1), (0, 0.1)])
    vertices = np.concatenate([np.c_[around, np.zeros(6)], np.c_[around, np.full(6, 0.02)]])
    fan = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)])
    one = np.arange(6)
    other = (one + 1) % 6
    sides = [np.stack([one, other, other + 6], 1), np.stack([one, other + 6, one + 6], 1)]
    bent = Surface(vertices, np.concatenate([fan[:, ::-1], fan + 6, *sides]))
    assert bent.volume() == pytest.approx(0.0036 * 0.02)
    with pytest.raises(InputError, match="sees nothing of the body"):
        seen_from(bent, np.array([0.09, 0.01, 0.01]), 10)
