"""Cameras of a COLMAP reconstruction."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np

from thermo.errors import InputError
from thermo.observe import check_number

from ._camera import Camera
from ._distortion import unknown_lens
from ._view import View

_HALF: Final = 0.5
"""The centre of COLMAP's first pixel lies at (0.5, 0.5), of ours at (0, 0) [px]."""

# Places of f_x, f_y, c_x, c_y and of k1, k2, p1, p2, k3 among each model's parameters.
_MODELS: Final[dict[str, tuple[tuple[int, ...], tuple[int, ...]]]] = {
    "SIMPLE_PINHOLE": ((0, 0, 1, 2), ()),
    "PINHOLE": ((0, 1, 2, 3), ()),
    "SIMPLE_RADIAL": ((0, 0, 1, 2), (3,)),
    "RADIAL": ((0, 0, 1, 2), (3, 4)),
    "OPENCV": ((0, 1, 2, 3), (4, 5, 6, 7)),
}


def read_colmap(folder: Path | str, *, scale: float | int = 1.0) -> tuple[View, ...]:
    """Cameras of a folder that COLMAP left: `cameras`, `images` and `points3D`, `.bin` or `.txt`.

    Arguments: `folder`; `scale`, the length of its unit [m], which COLMAP itself cannot know.

    Needs the extra `thermofield[colmap]`. Raises `InputError` where that is missing, where the
    folder cannot be read, and for a lens beyond radial and tangential coefficients.

    Source: COLMAP, "Output format" and "Camera models".
    """
    folder = Path(folder)
    unit = check_number(scale, where="cameras.scale", quantity="length of a unit [m]", above=0.0)
    found = _load(folder)
    views = []
    for number in sorted(found.images):
        image = found.images[number]
        where = f"{folder}: {image.name}"
        pose = np.eye(4)
        pose[:3] = np.asarray(image.cam_from_world().matrix())
        pose[:3, 3] *= unit
        views.append(View(_camera(found.cameras[image.camera_id], pose, image.name, where),
                          image.name))  # fmt: skip
    if not views:
        raise _refusal(folder, "a reconstruction without pictures")
    return tuple(views)


def _camera(given: Any, pose: np.ndarray, name: str, where: str) -> Camera:
    model, numbers = given.model.name, np.asarray(given.params, float)
    if model not in _MODELS:
        raise unknown_lens(where, model, ", ".join(_MODELS))
    places, bends = _MODELS[model]
    f_x, f_y, c_x, c_y = numbers[list(places)]
    distortion = np.zeros(5)
    distortion[: len(bends)] = numbers[list(bends)]
    return Camera(
        given.width, given.height, (f_x, f_y), (c_x - _HALF, c_y - _HALF), pose, distortion,
        name=Path(name).stem, where=where,
    )  # fmt: skip


def _load(folder: Path) -> Any:
    try:
        import pycolmap  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        raise InputError(
            "COLMAP's files need an extra package", where=str(folder), value="no pycolmap",
            limit="the package pycolmap", remedy="pip install 'thermofield[colmap]'",
        ) from error  # fmt: skip
    try:
        return pycolmap.Reconstruction(str(folder))
    except Exception as error:  # its C++ raises whatever it meets
        raise _refusal(folder, f"{type(error).__name__}: {str(error)[:160]}") from error


def _refusal(folder: Path, value: str) -> InputError:
    return InputError(
        "this COLMAP folder cannot be read", where=str(folder), value=value,
        limit="cameras, images and points3D, as .bin or .txt",
        remedy="give the folder of one reconstruction, such as sparse/0",
    )  # fmt: skip
