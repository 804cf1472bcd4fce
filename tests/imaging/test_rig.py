"""A thermal camera fixed to a colour camera."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from cameras import camera_at
from scipy.spatial.transform import Rotation

from thermo.errors import InputError
from thermo.imaging import Rig, View, project, read_rig, rig_from_poses, thermal_views, write_rig

BETWEEN = np.eye(4)
BETWEEN[:3, :3] = Rotation.from_rotvec([0.01, -0.03, 0.02]).as_matrix()
BETWEEN[:3, 3] = (0.05, 0.0, 0.002)
RIG = Rig(32, 24, (40.0, 41.0), (15.5, 11.5), BETWEEN, (-0.1, 0.0, 0.0, 0.0, 0.0))
COLOUR = [View(camera_at((0.5, 0.1 * k, 0.2), name=f"v{k}"), f"{k}.png", k) for k in (0.0, 1.0)]


def test_the_thermal_camera_goes_with_the_colour_camera() -> None:
    for view, one in zip(COLOUR, thermal_views(RIG, COLOUR), strict=True):
        np.testing.assert_allclose(one.camera.pose, BETWEEN @ view.camera.pose, atol=1e-14)
        assert (one.camera.width, one.camera.name, one.file) == (32, view.camera.name, view.file)
        assert one.camera.distortion[0] == -0.1


def test_a_rig_is_read_as_it_was_written(tmp_path: Path) -> None:
    write_rig(tmp_path / "rig.json", RIG)
    again = read_rig(tmp_path / "rig.json")
    points = np.random.default_rng(0).uniform(-0.05, 0.05, (9, 3)) + [0.0, 0.0, 0.4]
    seen, _ = project(RIG.thermal, points)
    assert np.abs(project(again.thermal, points)[0] - seen).max() < 1e-9
    np.testing.assert_allclose(again.colour_to_thermal(), BETWEEN, atol=1e-15)


def test_poses_of_both_tell_the_rig() -> None:
    thermal = thermal_views(RIG, COLOUR)
    rig, angle, shift = rig_from_poses(thermal, COLOUR)
    np.testing.assert_allclose(rig.colour_to_thermal(), BETWEEN, atol=1e-12)
    assert angle < 1e-9 and shift < 1e-12
    # One of two turned by 0.2 degrees about an axis: each strays by half of it.
    off = np.eye(4)
    off[:3, :3] = Rotation.from_rotvec([0.0, np.radians(0.2), 0.0]).as_matrix()
    first = thermal[0].camera
    turned = type(first)(32, 24, first.focal, first.centre, off @ first.pose)
    _, angle, _ = rig_from_poses([View(turned, ""), thermal[1]], COLOUR)
    assert angle == pytest.approx(0.1, rel=1e-6)
    with pytest.raises(InputError, match="2 and 1"):
        rig_from_poses(thermal, COLOUR[:1])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"format": "other"}, "no rig"),
        ({"thermal": {"width": 3}}, "lacks a part"),
        ({"colour_to_thermal": [[1, 0], [0, 1]]}, "colour_to_thermal: this pose is no"),
    ],
)
def test_what_is_no_rig_is_refused(tmp_path: Path, change: dict, words: str) -> None:
    path = tmp_path / "rig.json"
    write_rig(path, RIG)
    path.write_text(json.dumps(json.loads(path.read_text("utf-8")) | change), "utf-8")
    with pytest.raises(InputError, match=words):
        read_rig(path)
