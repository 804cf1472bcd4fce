"""Cameras from a file of any known format."""

from __future__ import annotations

from pathlib import Path

from thermo.errors import InputError

from ._colmap import read_colmap
from ._middlebury import read_middlebury
from ._pose import Axes
from ._transforms_json import read_transforms
from ._view import View


def read_cameras(
    path: Path | str, *, scale: float | int | None = None, axes: Axes | None = None
) -> tuple[View, ...]:
    """Cameras of a `transforms.json`, of a Middlebury `*_par.txt`, or of COLMAP's folder.

    Arguments:

    - `path`: the file or folder; what it is follows from its name and nothing else.
    - `scale`: length of its unit [m]; None takes what it says itself, or a metre.
    - `axes`: which way its cameras' axes point, where a `transforms.json` is not as it should be.

    Raises `InputError` for what cannot be read, for cameras of one name, and where `axes` or
    `scale` are given for a format that fixes them.
    """
    path = Path(path)
    if path.is_dir():
        _fixed(axes, path, "axes", "COLMAP's are OpenCV's")
        views = read_colmap(path, scale=1.0 if scale is None else scale)
    elif path.suffix == ".json":
        views = read_transforms(path, scale=scale, axes=axes)
    elif path.name.endswith("_par.txt"):
        _fixed(axes, path, "axes", "Middlebury's are OpenCV's")
        _fixed(scale, path, "scale", "Middlebury's unit is the metre")
        views = read_middlebury(path)
    else:
        raise InputError(
            "this is no file of cameras", where="cameras", value=str(path),
            limit="transforms.json, *_par.txt, or a folder of COLMAP",
            remedy="export the cameras in one of these formats",
        )  # fmt: skip
    return views


def _fixed(value: object, path: Path, key: str, why: str) -> None:
    if value is not None:
        raise InputError(
            f"`{key}` is fixed by the format", where=str(path), value=value, limit=why,
            remedy=f"leave cameras.{key} out",
        )  # fmt: skip
