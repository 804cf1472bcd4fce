"""Cameras about the origin."""

from __future__ import annotations

import numpy as np

from thermo.imaging import Camera, looking_at

UP = np.array([0.0, 0.0, 1.0])


def camera_at(
    place: tuple[float, float, float], *, size: tuple[int, int] = (64, 48), focal: float = 80.0,
    bends: tuple[float, ...] = (0.0,) * 5, name: str = "camera",
) -> Camera:  # fmt: skip
    """A camera at `place` [m] that looks at the origin."""
    wide, high = size
    pose = looking_at(np.array(place), np.zeros(3), UP)
    centre = ((wide - 1) / 2, (high - 1) / 2)
    return Camera(wide, high, (focal, focal), centre, pose, bends, name=name)
