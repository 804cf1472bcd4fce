"""Poses, in both conventions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from thermo.errors import InputError
from thermo.imaging import Axes, camera_to_world, looking_at, world_to_camera
from thermo.imaging._pose import checked_pose

numbers = st.floats(-3.0, 3.0)


def rigid(turn: tuple[float, ...], shift: tuple[float, ...]) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(np.array(turn)).as_matrix()
    pose[:3, 3] = shift
    return pose


@given(st.tuples(numbers, numbers, numbers), st.tuples(numbers, numbers, numbers))
def test_both_conventions_go_there_and_back(turn: tuple, shift: tuple) -> None:
    pose = rigid(turn, shift)
    for axes in Axes:
        np.testing.assert_allclose(world_to_camera(camera_to_world(pose, axes), axes), pose,
                                   atol=1e-12)  # fmt: skip


def test_an_opengl_camera_looks_along_its_negative_z() -> None:
    # At rest, an OpenGL camera at z = 2 that is not turned looks down on the origin.
    matrix = np.eye(4)
    matrix[2, 3] = 2.0
    pose = world_to_camera(matrix, Axes.OPENGL)
    np.testing.assert_allclose(pose @ [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 2.0, 1.0])
    above = pose @ [0.0, 1.0, 0.0, 1.0]
    assert above[1] == -1.0, "what is above has a smaller row"
    behind = world_to_camera(matrix, Axes.OPENCV) @ [0.0, 0.0, 0.0, 1.0]
    assert behind[2] == -2.0


def test_a_camera_looks_at_its_target_upright() -> None:
    place, target = np.array([1.0, 2.0, 0.5]), np.array([0.0, 0.2, 0.1])
    pose = looking_at(place, target, np.array([0.0, 0.0, 1.0]))
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)
    seen = pose[:3, :3] @ target + pose[:3, 3]
    np.testing.assert_allclose(seen, [0.0, 0.0, np.linalg.norm(target - place)], atol=1e-12)
    higher = pose[:3, :3] @ (target + [0.0, 0.0, 0.1]) + pose[:3, 3]
    assert higher[1] < 0 and higher[0] == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(InputError, match="no upright"):
        looking_at(place, place + [0.0, 0.0, 1.0], np.array([0.0, 0.0, 2.0]))


@pytest.mark.parametrize(
    ("matrix", "words"),
    [
        (np.eye(3), "no transformation"),
        (np.full((4, 4), np.nan), "no transformation"),
        (2.0 * np.eye(4), "last row"),
        (np.diag([2.0, 2.0, 2.0, 1.0]), "axes of length 2, 2, 2"),
        (np.diag([1.0, 1.0, -1.0, 1.0]), "mirror"),
    ],
)
def test_what_is_no_pose_is_refused(matrix: np.ndarray, words: str) -> None:
    with pytest.raises(InputError, match=words):
        checked_pose(matrix, where="frames[3]")


def test_rounded_rotations_are_made_exact() -> None:
    pose = np.round(rigid((0.3, -0.2, 0.9), (1.0, 2.0, 3.0)), 6)
    made = checked_pose(pose[:3], where="poses")
    np.testing.assert_allclose(made[:3, :3] @ made[:3, :3].T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(made, pose, atol=2e-6)
