"""Cameras in nerfstudio's file."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cameras import camera_at

from thermo.errors import InputError
from thermo.imaging import Axes, View, project, read_cameras, write_transforms

POINTS = np.random.default_rng(0).uniform(-0.05, 0.05, (20, 3))
BENT = (-0.3, 0.1, 0.001, -0.002, 0.03)


def write(path: Path, **table: Any) -> Path:
    path.write_text(json.dumps(table), "utf-8")
    return path


def frame(**more: Any) -> dict[str, Any]:
    matrix = np.eye(4)
    matrix[2, 3] = 2.0
    return {"transform_matrix": matrix.tolist(), "file_path": "images/a.png", **more}


CALIBRATION = {"w": 64, "h": 48, "fl_x": 80.0, "fl_y": 81.0, "cx": 32.0, "cy": 24.0}


def test_cameras_are_read_as_they_were_written(tmp_path: Path) -> None:
    views = [
        View(camera_at((0.5, 0.1, 0.2), bends=BENT, name="left"), "left.npz"),
        View(camera_at((-0.2, 0.6, 0.1), size=(32, 24), name="right"), "right.npz", 1.5),
    ]
    path = tmp_path / "transforms.json"
    write_transforms(path, views)
    again = read_cameras(path)
    assert [(one.file, one.time, one.camera.name) for one in again] == [
        ("left.npz", None, "left"), ("right.npz", 1.5, "right"),
    ]  # fmt: skip
    for one, two in zip(views, again, strict=True):
        assert (one.camera.width, one.camera.height) == (two.camera.width, two.camera.height)
        seen, depth = project(one.camera, POINTS)
        seen_again, depth_again = project(two.camera, POINTS)
        assert np.abs(seen - seen_again).max() < 1e-9
        np.testing.assert_allclose(depth, depth_again, atol=1e-12)


def test_a_plain_file_is_of_opengl_s_axes_and_half_a_pixel_off(tmp_path: Path) -> None:
    path = write(tmp_path / "t.json", frames=[frame()], **CALIBRATION)
    camera = read_cameras(path)[0].camera
    pixels, depth = project(camera, np.array([[0.0, 0.0, 0.0], [0.1, 0.1, 0.0]]))
    assert depth.tolist() == [2.0, 2.0]
    # A point above is in a row further up; c_x = 32 of 64 columns is our 31.5, the middle.
    np.testing.assert_allclose(pixels, [[31.5, 23.5], [31.5 + 4.0, 23.5 - 4.05]])
    assert camera.name == "a"


def test_axes_and_scale_are_as_stated(tmp_path: Path) -> None:
    path = write(tmp_path / "t.json", frames=[frame()], metres_per_unit=0.01, **CALIBRATION)
    assert read_cameras(path)[0].camera.place().tolist() == pytest.approx([0, 0, 0.02])
    assert read_cameras(path, scale=2.0)[0].camera.place()[2] == pytest.approx(4.0)
    behind = read_cameras(path, axes=Axes.OPENCV)[0].camera
    assert project(behind, np.zeros((1, 3)))[1][0] == pytest.approx(-0.02)
    said = write(tmp_path / "o.json", frames=[frame()], camera_axes="opencv", **CALIBRATION)
    assert project(read_cameras(said)[0].camera, np.zeros((1, 3)))[1][0] == -2.0


def test_what_nerfstudio_s_tools_applied_is_undone(tmp_path: Path) -> None:
    # A camera at rest, moved by a quarter turn and a shift, then scaled by four.
    turn = np.array([[0.0, 1.0, 0.0, 0.5], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0]])
    first = np.eye(4)
    first[:3, 3] = (0.1, 0.2, 2.0)
    moved = np.vstack([turn, [0, 0, 0, 1]]) @ first
    moved[:3, 3] *= 4.0
    path = write(
        tmp_path / "t.json", frames=[frame(transform_matrix=moved.tolist())],
        applied_transform=turn.tolist(), applied_scale=4.0, **CALIBRATION,
    )  # fmt: skip
    camera = read_cameras(path)[0].camera
    np.testing.assert_allclose(camera.place(), [0.1, 0.2, 2.0], atol=1e-12)
    assert project(camera, np.zeros((1, 3)))[1][0] == pytest.approx(2.0)


def test_a_frame_s_own_calibration_counts_and_angles_give_focal_lengths(tmp_path: Path) -> None:
    wide = frame(w=100, h=50, camera_angle_x=math.pi / 2)
    path = write(tmp_path / "t.json", frames=[wide])
    camera = read_cameras(path)[0].camera
    assert camera.focal.tolist() == pytest.approx([50.0, 50.0])
    assert camera.centre.tolist() == [49.5, 24.5]
    path = write(tmp_path / "u.json", frames=[frame(fl_x=10.0), frame()], **CALIBRATION)
    assert [one.camera.focal[0] for one in read_cameras(path)] == [10.0, 80.0]


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({}, "no cameras"),
        ({"frames": [frame()]}, r"`w` is missing"),
        ({"frames": [{"file_path": "a"}]} | CALIBRATION, "`transform_matrix` is missing"),
        ({"frames": [frame(), 3]} | CALIBRATION, r"frames\[1\]"),
        ({"frames": [frame(w=4.5)]} | CALIBRATION | {"w": 3}, "whole number"),
        (
            {"frames": [frame(camera_model="OPENCV_FISHEYE")]} | CALIBRATION,
            r"lens is a fisheye(.|\n)*OPENCV_FISHEYE(.|\n)*fisheye.undistortImage",
        ),
        ({"frames": [frame()], "is_fisheye": True} | CALIBRATION, "OPENCV, with is_fisheye"),
        ({"frames": [frame(camera_model="EQUIRECTANGULAR")]} | CALIBRATION, "lens is not known"),
        ({"frames": [frame(k4=0.01)]} | CALIBRATION, "OPENCV, with k4 0.01"),
        ({"frames": [frame()], "camera_axes": "blender"} | CALIBRATION, "axes are not known"),
        ({"frames": [frame()], "metres_per_unit": 0} | CALIBRATION, "out of range"),
        ({"frames": [frame(transform_matrix=(2 * np.eye(3)).tolist())]} | CALIBRATION, "pose"),
        ({"frames": [frame()], "w": 64, "h": 48}, "`fl_x` is missing"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, table: dict[str, Any], words: str) -> None:
    path = write(tmp_path / "t.json", **table)
    with pytest.raises(InputError, match=words) as caught:
        read_cameras(path)
    assert str(path) in str(caught.value)


def test_what_is_no_table_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "t.json"
    with pytest.raises(InputError, match="no such file"):
        read_cameras(path)
    path.write_text("[1, 2", "utf-8")
    with pytest.raises(InputError, match="JSONDecodeError"):
        read_cameras(path)
    with pytest.raises(InputError, match="no file of cameras"):
        read_cameras(tmp_path / "cameras.xml")
