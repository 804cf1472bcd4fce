"""Where the lines of sight of cameras meet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.imaging import Camera, rays

from ._photograph import Photograph
from ._visual_hull import Cone

_ROUNDS: Final = 30
"""How often lines are weighed anew [1]."""
_ALIKE: Final = 1e-3
"""Least share of the lines' directions that must lie across their mean [1]; 1e-3 is 2 degrees."""


@final
class Sight(eqx.Module):
    """What a camera looks at.

    - `place`: where it stands, (3,) [m]. `line`: that it looks along, (3,) [1].
    - `wide`: tangent of the angle from that line to the edge of what it looks at [1].
    """

    place: Float[np.ndarray, "3"]
    line: Float[np.ndarray, "3"]
    wide: float


def sight_of_object(cone: Cone) -> Sight:
    """Along the middle of the object in a picture, as wide as the circle about its box."""
    row, column = np.nonzero(cone.beyond == 0)
    low = np.array([column.min(), row.min()], float)
    high = np.array([column.max(), row.max()], float)
    wide = 0.5 * float(np.linalg.norm(high - low + 1)) / float(cone.camera.focal.min())
    return _sight(cone.camera, 0.5 * (low + high), wide)


def sight_of_picture(photograph: Photograph) -> Sight:
    """Along the middle of a picture, as wide as the circle that fits into it."""
    camera = photograph.camera
    wide = 0.5 * min(camera.width, camera.height) / float(camera.focal.max())
    return _sight(camera, np.array([camera.width - 1, camera.height - 1]) / 2, wide)


def meeting(sights: Sequence[Sight]) -> tuple[Float[np.ndarray, "3"], float]:
    """The point of the least sum of distances to the lines, and the median radius there [m].

    Lines count to both sides of their cameras, so that cameras of another convention of axes, which
    look away, meet where they should look. The sum of distances, found by weighing each line by
    one over its own, heeds no single camera that stands wrong.

    Raises `InputError` for fewer than two lines, and where all run alike or begin in one place.

    Source: Weiszfeld, Tohoku Mathematical Journal 43 (1937) 355.
    """
    places = np.stack([one.place for one in sights]) if sights else np.zeros((0, 3))
    lines = np.stack([one.line for one in sights]) if sights else np.zeros((0, 3))
    across = np.eye(3) - lines[:, :, None] * lines[:, None, :]
    spread = np.linalg.norm(places - places.mean(axis=0)) if len(sights) else 0.0
    if len(sights) < 2 or not np.linalg.eigvalsh(across.mean(axis=0))[0] > _ALIKE or not spread:
        raise InputError(
            "nothing says where the object is", where="cameras", value=f"{len(sights)} cameras",
            limit="two or more that look at it from different places and sides",
            remedy="state the object's box, and see whether the poses are those of the pictures",
        )  # fmt: skip
    weight = np.ones(len(sights))
    for _ in range(_ROUNDS):
        matrix = (weight[:, None, None] * across).sum(axis=0)
        centre = np.linalg.solve(matrix, np.einsum("i,ijk,ik->j", weight, across, places))
        off = np.linalg.norm(np.einsum("ijk,ik->ij", across, centre - places), axis=1)
        weight = 1.0 / np.maximum(off, 1e-6 * spread)
    wide = np.array([one.wide for one in sights])
    return centre, float(np.median(np.linalg.norm(centre - places, axis=1) * wide))


def _sight(camera: Camera, pixel: Float[np.ndarray, "2"], wide: float) -> Sight:
    line = rays(camera, pixel[None])[0]
    # A lens that folds its picture may bring nothing to a pixel.
    return Sight(camera.place(), line if np.isfinite(line).all() else camera.pose[2, :3], wide)
