from __future__ import annotations

import numpy as np
import pytest
import trimesh

from thermo.report._object import length_text, round_length, two_views
from thermo.report._render import Camera, View, camera_axes, corner_normals, render, visible

SQUARE = np.array([[0, 1, 2], [0, 2, 3]])


def square(z: float, size: float) -> np.ndarray:
    return np.array([[0, 0, z], [size, 0, z], [size, size, z], [0, size, z]], dtype=float)


def from_above(nodes: np.ndarray, faces: np.ndarray) -> View:
    axes = camera_axes(-np.pi / 2, np.pi / 2)
    return render(nodes, faces, Camera(axes, np.array([-0.5, -0.5]), 0.1, 20, 20))


def test_axes_are_a_right_handed_frame() -> None:
    axes = camera_axes(0.3, -1.1)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    # Seen from above with x to the right, y is up.
    np.testing.assert_allclose(camera_axes(-np.pi / 2, np.pi / 2), np.eye(3), atol=1e-15)


def test_a_square_covers_its_pixels() -> None:
    view = from_above(square(0.0, 1.0), SQUARE)
    seen = view.face >= 0
    expected = np.zeros((20, 20), bool)
    expected[5:15, 5:15] = True
    np.testing.assert_array_equal(seen, expected)
    assert set(np.unique(view.face)) == {-1, 0, 1}
    # The right-hand face of the diagonal is the first one.
    assert view.face[6, 13] == 0 and view.face[13, 6] == 1


@pytest.mark.parametrize("order", [1, -1])
def test_the_nearer_face_hides_the_other_in_any_order(order: int) -> None:
    nodes = np.vstack([square(0.0, 1.0), square(0.5, 0.5)])
    faces = np.vstack([SQUARE, SQUARE + 4])[::order]
    view = from_above(nodes, faces)
    near = np.isin(view.face, [2, 3] if order == 1 else [0, 1])
    assert near.sum() == 25 and near[5:10, 5:10].all()
    points = np.array([[0.2, 0.2, 0.5], [0.2, 0.2, 0.0], [0.8, 0.8, 0.0], [0.2, 0.2, 0.48]])
    np.testing.assert_array_equal(visible(view, points, 0.03), [True, False, True, True])


def test_faces_that_look_away_are_left_out() -> None:
    assert (from_above(square(0.0, 1.0), SQUARE[:, ::-1]).face == -1).all()


def test_normals_are_smooth_on_a_ball_and_sharp_on_a_box() -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    nodes, faces = np.asarray(ball.vertices), np.asarray(ball.faces)
    np.testing.assert_allclose(corner_normals(nodes, faces), nodes[faces], atol=0.02)
    box = trimesh.creation.box()
    flat = np.repeat(np.asarray(box.face_normals)[:, None], 3, axis=1)
    found = corner_normals(np.asarray(box.vertices), np.asarray(box.faces))
    np.testing.assert_allclose(found, flat, atol=1e-12)


def test_both_views_hold_the_whole_object() -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    views = two_views(np.asarray(ball.vertices), np.asarray(ball.faces))
    for view in views:
        area = (view.face >= 0).sum() * view.camera.pixel**2
        assert area == pytest.approx(np.pi, rel=0.02)
        edge = np.concatenate([view.face[[0, -1]].ravel(), view.face[:, [0, -1]].ravel()])
        assert (edge == -1).all()
    assert views[0].face.shape == views[1].face.shape


@pytest.mark.parametrize(
    ("length", "expected"), [(0.017, 0.01), (0.02, 0.02), (0.0499, 0.02), (0.7, 0.5), (3.0, 2.0)]
)
def test_round_lengths(length: float, expected: float) -> None:
    assert round_length(length) == pytest.approx(expected)


def test_length_text() -> None:
    assert [length_text(x) for x in (0.02, 0.0005, 2.0)] == ["20 mm", "0.5 mm", "2 m"]
