"""Cameras in the `*_par.txt` of the Middlebury multi-view data."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError

from thermo.errors import InputError
from thermo.observe import write_whole

from ._camera import Camera
from ._view import View


def read_middlebury(path: Path | str, *, size: tuple[int, int] | None = None) -> tuple[View, ...]:
    """Cameras of a Middlebury file: name, K, R and t of each picture, x = K [R t] X.

    Arguments:

    - `path`: the file: a count, then a line `name k11 .. k33 r11 .. r33 t1 t2 t3` a picture.
    - `size`: width and height of the pictures [px]; None reads them from the pictures beside the
      file.

    Lengths are metres, as in that data [m]. Raises `InputError` with the number of the line for
    what is missing or cannot be, such as a skewed K.

    Source: Seitz, Curless, Diebel, Scharstein, Szeliski, CVPR (2006) 519.
    """
    path = Path(path)
    try:
        lines = path.read_text("utf-8").split("\n")
    except (OSError, UnicodeDecodeError) as error:
        raise _refusal(path, f"{type(error).__name__}: {error}") from error
    lines = [line.split() for line in lines if line.strip()]
    if not lines or len(lines[0]) != 1 or lines[0][0] != str(len(lines) - 1):
        first = " ".join(lines[0])[:60] if lines else "nothing"
        raise _refusal(path, f"{max(len(lines) - 1, 0)} pictures after the line `{first}`")
    return tuple(_view(path, words, number, size) for number, words in enumerate(lines[1:], 2))


def write_middlebury(path: Path | str, views: Sequence[View]) -> None:
    """Write cameras as Middlebury does, K in pixels and t in metres [m].

    Raises `InputError` for a lens that bends, which the format cannot hold, and where the folder
    takes no file.
    """
    path = Path(path)
    rows = [str(len(views))]
    for view in views:
        camera = view.camera
        if np.any(camera.distortion):
            raise InputError(
                "this lens bends, and the format cannot say so", where=str(path),
                value=f"{camera.name}: {camera.distortion.tolist()}", limit="coefficients of 0",
                remedy="write transforms.json",
            )  # fmt: skip
        matrix = np.diag([*camera.focal, 1.0])
        matrix[:2, 2] = camera.centre
        numbers = [*matrix.ravel(), *camera.pose[:3, :3].ravel(), *camera.pose[:3, 3]]
        rows.append(" ".join([view.file, *(f"{one:.17g}" for one in numbers)]))
    with write_whole(path, make_folder=False) as temporary:
        temporary.write_text("\n".join(rows) + "\n", "utf-8")


def _view(path: Path, words: list[str], number: int, size: tuple[int, int] | None) -> View:
    where = f"{path}: line {number}"
    try:
        values = np.array([float(word) for word in words[1:]])
    except ValueError:
        values = np.zeros(0)
    if values.shape != (21,):
        raise InputError(
            "this line is no camera", where=where, value=" ".join(words)[:80],
            limit="a name and 21 numbers: K and R row by row, then t",
            remedy="compare with the description of the data",
        )  # fmt: skip
    matrix, pose = values[:9].reshape(3, 3), np.eye(4)
    pose[:3, :3], pose[:3, 3] = values[9:18].reshape(3, 3), values[18:]
    if matrix[0, 1] or matrix[1, 0] or not np.array_equal(matrix[2], [0.0, 0.0, 1.0]):
        raise InputError(
            "this K is no camera's with upright pixels", where=where, value=matrix.tolist(),
            limit="[[f_x, 0, c_x], [0, f_y, c_y], [0, 0, 1]]", remedy="rectify the pictures first",
        )  # fmt: skip
    wide, high = size or _size(path.parent / words[0], where)
    focal, centre = (matrix[0, 0], matrix[1, 1]), matrix[:2, 2]
    camera = Camera(wide, high, focal, centre, pose, name=Path(words[0]).stem, where=where)
    return View(camera, words[0])


def _size(picture: Path, where: str) -> tuple[int, int]:
    try:
        with Image.open(picture) as image:
            return image.size
    except (OSError, UnidentifiedImageError) as error:
        raise InputError(
            "the size of the pictures is not known", where=where, value=f"{picture}: {error}",
            limit="the picture beside the file, or a stated size",
            remedy="put the pictures there, or give width and height",
        ) from error  # fmt: skip


def _refusal(path: Path, value: str) -> InputError:
    return InputError(
        "this is no Middlebury camera file", where=str(path), value=value,
        limit="the count of pictures, then a line each", remedy="check the name of the file",
    )  # fmt: skip
