"""Cameras in nerfstudio's `transforms.json`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from thermo.errors import InputError
from thermo.observe import check_number, real_array

from ._camera import Camera
from ._distortion import unknown_lens
from ._json_file import read_table, write_table
from ._pose import Axes, camera_to_world, checked_pose, world_to_camera
from ._view import View

_HALF: Final = 0.5
"""The centre of nerfstudio's first pixel lies at (0.5, 0.5), of ours at (0, 0) [px]."""

_MODELS: Final = ("OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL")
"""Lenses that the five coefficients of Brown and Conrady hold."""

_COEFFICIENTS: Final = ("k1", "k2", "p1", "p2", "k3")

METRES: Final = "metres_per_unit"
"""Our key of the length of the file's unit [m]; nerfstudio leaves other keys alone."""

AXES: Final = "camera_axes"
"""Our key of the way in which a camera's axes point; without it they are OpenGL's."""


def read_transforms(
    path: Path | str, *, scale: float | int | None = None, axes: Axes | None = None
) -> tuple[View, ...]:
    """Cameras of a `transforms.json`.

    The file's `transform_matrix` brings a camera's axes, which are OpenGL's, to the world. Where
    the file holds `applied_transform` and `applied_scale`, as nerfstudio's own tools leave them,
    they are undone. Its calibration stands once for all frames, or in each.

    Arguments:

    - `path`: the file.
    - `scale`: length of the file's unit [m]; None takes what the file says itself
      (`metres_per_unit`), or 1 m.
    - `axes`: which way the axes of its cameras point, where it is not as the format says; None
      takes what the file says itself (`camera_axes`), or OpenGL's.

    Raises `InputError` for what is missing or cannot be, with the number of the frame.

    Source: nerfstudio, "Data conventions".
    """
    path = Path(path)
    table = read_table(path, what="the table of cameras")
    frames = table.get("frames")
    if not isinstance(frames, list) or not frames:
        raise InputError(
            "there are no cameras", where=f"{path}: frames", value=type(frames).__name__,
            limit="a list with one entry a picture", remedy="export the poses as transforms.json",
        )  # fmt: skip
    unit = check_number(
        table.get(METRES, 1.0) if scale is None else scale, where=f"{path}: {METRES}",
        quantity="length of the file's unit [m]", above=0.0,
    )  # fmt: skip
    pointing = _axes(table, path) if axes is None else axes
    undo, factor = _applied(table, path)
    return tuple(
        _view(frame, table, undo, factor / unit, pointing, f"{path}: frames[{number}]")
        for number, frame in enumerate(frames)
    )


def write_transforms(path: Path | str, views: Sequence[View]) -> None:
    """Write cameras as `transforms.json`, in metres and OpenGL's axes, calibration in each frame.

    `read_transforms` gives every camera back to rounding. Raises `InputError` where the folder
    takes no file.
    """
    write_table(
        Path(path), {METRES: 1.0, AXES: Axes.OPENGL.value, "frames": [_frame(v) for v in views]}
    )


def _frame(view: View) -> dict[str, Any]:
    camera = view.camera
    frame: dict[str, Any] = {
        "file_path": view.file,
        "name": camera.name,
        "camera_model": "OPENCV",
        "w": camera.width,
        "h": camera.height,
        "fl_x": float(camera.focal[0]),
        "fl_y": float(camera.focal[1]),
        "cx": float(camera.centre[0]) + _HALF,
        "cy": float(camera.centre[1]) + _HALF,
        **dict(zip(_COEFFICIENTS, map(float, camera.distortion), strict=True)),
        "transform_matrix": camera_to_world(camera.pose, Axes.OPENGL).tolist(),
    }
    return frame if view.time is None else frame | {"time": view.time}


def _view(
    frame: object,
    table: Mapping[str, Any],
    undo: np.ndarray,
    shrink: float,
    axes: Axes,
    where: str,
) -> View:
    if not isinstance(frame, Mapping):
        raise _missing(where, "no table", "transform_matrix")
    if "transform_matrix" not in frame:
        raise _missing(where, ", ".join(map(str, frame)), "transform_matrix")
    # What stands in a frame counts, what stands above all frames is for those that lack it.
    known = {**table, **frame}
    matrix = real_array(
        frame["transform_matrix"], where=f"{where}: transform_matrix", quantity="pose"
    )
    pose = checked_pose(matrix, where=f"{where}: transform_matrix")
    pose = undo @ pose
    pose[:3, 3] /= shrink
    file, time = str(frame.get("file_path", "")), frame.get("time")
    if time is not None:
        time = check_number(time, where=f"{where}: time", quantity="time [s]")
    camera = _calibrated(known, world_to_camera(pose, axes), file, where)
    return View(camera, file, time)


def _calibrated(known: Mapping[str, Any], pose: np.ndarray, file: str, where: str) -> Camera:
    model, bent = str(known.get("camera_model", "OPENCV")), known.get("k4", 0.0)
    fisheye = bool(known.get("is_fisheye", False))
    if model not in _MODELS or bent or fisheye:
        more = (f", with k4 {bent}" if bent else "") + (", with is_fisheye" if fisheye else "")
        raise unknown_lens(
            f"{where}: camera_model", model + more, f"{', '.join(_MODELS)}, with k4 0",
            fisheye=fisheye,
        )  # fmt: skip
    size = _whole(known, "w", where), _whole(known, "h", where)
    across = known.get("camera_angle_x")
    if "fl_x" in known:
        focal = float(_number(known, "fl_x", where))
        focals = (focal, float(_number(known, "fl_y", where)) if "fl_y" in known else focal)
    elif across is not None:
        angle = check_number(across, where=f"{where}: camera_angle_x", quantity="angle [rad]",
                             above=0.0, most=math.pi)  # fmt: skip
        focals = (0.5 * size[0] / math.tan(angle / 2),) * 2
    else:
        raise _missing(where, ", ".join(map(str, known)), "fl_x")
    middle = [
        (_number(known, key, where) if key in known else edge / 2) - _HALF
        for key, edge in zip(("cx", "cy"), size, strict=True)
    ]
    bends = [_number(known, key, where) if key in known else 0.0 for key in _COEFFICIENTS]
    name = str(known.get("name") or Path(file).stem or "camera")
    return Camera(size[0], size[1], focals, middle, pose, bends, name=name, where=where)


def _applied(table: Mapping[str, Any], path: Path) -> tuple[np.ndarray, float]:
    """What undoes the shift and turn of nerfstudio's tools, and their scale."""
    factor = 1.0
    if "applied_scale" in table:
        factor = check_number(
            table["applied_scale"], where=f"{path}: applied_scale", quantity="scale", above=0.0
        )
    if "applied_transform" not in table:
        return np.eye(4), factor
    given = checked_pose(table["applied_transform"], where=f"{path}: applied_transform")
    # It was applied before the scale: its shift has grown with all others.
    given[:3, 3] *= factor
    return np.linalg.inv(given), factor


def _axes(table: Mapping[str, Any], path: Path) -> Axes:
    named = table.get(AXES, Axes.OPENGL.value)
    known = [one.value for one in Axes]
    if named not in known:
        raise InputError(
            "these axes are not known", where=f"{path}: {AXES}", value=named,
            limit=" or ".join(known), remedy=f"remove {AXES}: nerfstudio's are OpenGL's",
        )  # fmt: skip
    return Axes(named)


def _number(known: Mapping[str, Any], key: str, where: str) -> float:
    return check_number(known[key], where=f"{where}: {key}", quantity=f"{key} [px]")


def _whole(known: Mapping[str, Any], key: str, where: str) -> int:
    if key not in known:
        raise _missing(where, ", ".join(map(str, known)), key)
    value = _number(known, key, where)
    if value != int(value):
        raise InputError(
            "a frame has no such size", where=f"{where}: {key}", value=value,
            limit="a whole number of pixels", remedy="give the size of the frames",
        )  # fmt: skip
    return int(value)


def _missing(where: str, found: str, key: str) -> InputError:
    return InputError(
        f"`{key}` is missing", where=where, value=found, limit=f"`{key}` here or above all frames",
        remedy="export the poses with their calibration, as nerfstudio's tools do",
    )  # fmt: skip
