"""A rebuilt object from all around."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from jaxtyping import Float
from PIL import Image

from thermo.imaging import Camera, looking_at
from thermo.observe import write_whole
from thermo.reconstruct import Photograph, Region, Trained, picture

VIEWS: Final = 6
"""How many sides are shown [1]."""
_EDGE: Final = 160
"""Of each picture [px]."""
_AWAY: Final = 4.0
"""Distance of the cameras over half the region's edge [1]."""
_RAISED: Final = 0.35
"""Height of the cameras over their distance [1]."""


def turntable(region: Region, up: Float[np.ndarray, "3"]) -> list[Camera]:
    """Cameras [m] round the region, a little above its middle.

    Arguments: `up`: the object's own upward direction, of length one [1].
    """
    aside = np.eye(3)[np.argmin(np.abs(up))]
    first = np.cross(up, aside)
    first /= np.linalg.norm(first)
    second = np.cross(up, first)
    # The cube's corners fit the picture.
    focal = 0.5 * _EDGE * (_AWAY - 1.0) / 1.5
    middle = ((_EDGE - 1) / 2,) * 2
    found = []
    for number in range(VIEWS):
        angle = 2.0 * np.pi * number / VIEWS
        flat = np.cos(angle) * first + np.sin(angle) * second
        way = np.sqrt(1.0 - _RAISED**2) * flat + _RAISED * up
        place = region.centre + _AWAY * region.half * way
        pose = looking_at(place, region.centre, up)
        found.append(Camera(_EDGE, _EDGE, (focal, focal), middle, pose, name=f"side{number}"))
    return found


def figure_turntable(path: Path, trained: Trained, up: Float[np.ndarray, "3"]) -> None:
    """Writes a PNG: above the colours that were learned, below the normals, from six sides.

    A normal's x, y and z in the camera's axes are red, green and blue; the ground is white.

    Arguments:

    - `path`: the file. `trained`: the surface. `up`: its upward direction, of length one [1].

    Raises `InputError` where the file cannot be written.
    """
    columns = [_column(trained, camera) for camera in turntable(trained.region, up)]
    whole = np.concatenate(columns, axis=1)
    with write_whole(path) as temporary:
        Image.fromarray(np.round(255 * np.clip(whole, 0.0, 1.0)).astype(np.uint8)).save(
            temporary, format="png"
        )


def _column(trained: Trained, camera: Camera) -> Float[np.ndarray, "rows columns 3"]:
    seen = picture(trained, camera)
    ground = 1.0 - seen.covered[..., None]
    normal = seen.normal @ camera.pose[:3, :3].T
    # Towards the camera is -z of its axes, and up is -y.
    shown = 0.5 + 0.5 * normal * np.array([1.0, -1.0, -1.0])
    both: Sequence[np.ndarray] = (seen.colour + ground, shown * seen.covered[..., None] + ground)
    return np.concatenate(both, axis=0)


def upward(photographs: Sequence[Photograph]) -> Float[np.ndarray, "3"]:
    """The direction that is upward in most pictures, of length one [1]; z where none is."""
    up = -np.mean([one.camera.pose[1, :3] for one in photographs], axis=0)
    length = float(np.linalg.norm(up))
    # Cameras that were turned all ways have no common upward.
    return up / length if length > 0.1 else np.array([0.0, 0.0, 1.0])
