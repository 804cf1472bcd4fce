"""Views of a rebuilt object from all around."""

from __future__ import annotations

import numpy as np
import pytest
from coloured_ball import CENTRE, cameras, photograph

from thermo.imaging import looking_at, project
from thermo.reconstruct import Region
from thermo.report import upward
from thermo.report._figure_turntable import VIEWS, turntable

REGION = Region(CENTRE, 0.05)


def test_every_camera_has_the_whole_region_in_its_picture_and_up_upward() -> None:
    up = np.array([0.0, 0.6, 0.8])
    found = turntable(REGION, up)
    assert len(found) == VIEWS
    corners = CENTRE + 0.05 * (2.0 * np.indices((2, 2, 2)).reshape(3, -1).T - 1.0)
    for camera in found:
        pixels, depth = project(camera, corners)
        assert (depth > 0).all() and (pixels > -0.5).all() and (pixels < camera.width - 0.5).all()
        assert (camera.place() - CENTRE) @ up > 0
        ends, _ = project(camera, CENTRE + np.array([-0.01, 0.01])[:, None] * up)
        assert ends[1, 1] < ends[0, 1], "what is higher stands higher in the picture"
    sides = np.stack([camera.place() - CENTRE for camera in found])
    assert np.linalg.norm(sides.sum(axis=0) - VIEWS * (sides[0] @ up) * up) < 1e-9


def test_upward_is_what_most_cameras_hold_upward() -> None:
    made = [photograph(camera) for camera in cameras(8)]
    assert upward(made) @ np.array([0.0, 0.3, 1.0]) / np.hypot(0.3, 1.0) > 0.9
    level = looking_at(np.array([1.0, 0.0, 0.0]), np.zeros(3), np.array([0.0, 0.0, 1.0]))
    assert -level[1, :3] == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)
