"""Where a camera stands: rigid transformations, and the two ways of naming a camera's axes."""

from __future__ import annotations

from enum import Enum
from typing import Final, final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.observe import real_array

_OFF: Final = 1e-4
"""What the product of a rotation with its transpose may differ from one by [1]."""


@final
class Axes(Enum):
    """Which way a camera's own axes point.

    - `OPENCV`: x to the right, y down, z forward (OpenCV, COLMAP, Middlebury).
    - `OPENGL`: x to the right, y up, z backward (OpenGL, Blender, nerfstudio).
    """

    OPENCV = "opencv"
    OPENGL = "opengl"


TURN: Final = np.diag([1.0, -1.0, -1.0, 1.0])
"""From one of the two conventions of axes to the other [1]."""


def world_to_camera(
    camera_to_world: Float[np.ndarray, "4 4"], axes: Axes
) -> Float[np.ndarray, "4 4"]:
    """The transformation [m] from the world to a camera of OpenCV's axes.

    Arguments: `camera_to_world`, for a camera of the given `axes`, its last column the camera's
    place [m].
    """
    turned = camera_to_world if axes is Axes.OPENCV else camera_to_world @ TURN
    return inverse_of(turned)


def camera_to_world(
    world_to_camera: Float[np.ndarray, "4 4"], axes: Axes
) -> Float[np.ndarray, "4 4"]:
    """The inverse of `world_to_camera` [m]: from a camera of the given `axes` to the world."""
    turned = inverse_of(world_to_camera)
    return turned if axes is Axes.OPENCV else turned @ TURN


def inverse_of(rigid: Float[np.ndarray, "4 4"]) -> Float[np.ndarray, "4 4"]:
    """The inverse of a rotation and a shift [m], without solving for it."""
    back = np.eye(4)
    back[:3, :3] = rigid[:3, :3].T
    back[:3, 3] = -rigid[:3, :3].T @ rigid[:3, 3]
    return back


def looking_at(
    place: Float[np.ndarray, "3"],
    target: Float[np.ndarray, "3"],
    up: Float[np.ndarray, "3"],
) -> Float[np.ndarray, "4 4"]:
    """World to camera for a camera at `place` [m] whose axis meets `target` [m].

    `up` [1] points to the upper edge of the picture. Raises `InputError` where the three lie on
    one line.
    """
    forward = target - place
    right = np.cross(forward, up)
    length = np.linalg.norm(right)
    if not length > 1e-9 * np.linalg.norm(forward) * np.linalg.norm(up):
        raise InputError(
            "this camera has no upright", where="up", value=np.asarray(up).tolist(),
            limit="a direction apart from the line of sight",
            remedy="give another direction for `up`, such as [0, 1, 0]",
        )  # fmt: skip
    forward, right = forward / np.linalg.norm(forward), right / length
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, np.cross(forward, right), forward])
    pose[:3, 3] = -pose[:3, :3] @ place
    return pose


def checked_pose(matrix: object, *, where: str) -> Float[np.ndarray, "4 4"]:
    """A rotation and a shift [m] as a matrix (4, 4) whose rotation is one to rounding.

    A matrix (3, 4) gets its last row. Raises `InputError`, naming `where`, for another shape, for
    numbers that are not finite, for a mirror image, and where the axes are not at right angles and
    of length one, as where a scale was multiplied in.
    """
    values = real_array(matrix, where=where, quantity="pose")
    if values.shape == (3, 4):
        values = np.vstack([values, [0.0, 0.0, 0.0, 1.0]])
    if values.shape != (4, 4) or not np.isfinite(values).all():
        raise _refusal("is no transformation", where, f"shape {values.shape}")
    if not np.allclose(values[3], [0.0, 0.0, 0.0, 1.0], atol=1e-9):
        raise _refusal("has another last row", where, values[3].tolist())
    turn = values[:3, :3]
    if np.abs(turn @ turn.T - np.eye(3)).max() > _OFF:
        lengths = np.linalg.norm(turn, axis=0)
        shown = ", ".join(f"{one:.4g}" for one in lengths)
        raise _refusal("does not turn alone", where, f"axes of length {shown}")
    if np.linalg.det(turn) < 0:
        raise _refusal("is a mirror image", where, f"determinant {np.linalg.det(turn):.3g}")
    left, _, right = np.linalg.svd(turn)
    exact = values.copy()
    exact[:3, :3] = left @ right
    return exact


def _refusal(what: str, where: str, value: object) -> InputError:
    return InputError(
        f"this pose {what}", where=where, value=value,
        limit="a rotation (determinant 1) and a shift in metres, shape (4, 4) or (3, 4)",
        remedy="give scale apart from poses, and right-handed axes",
    )  # fmt: skip
