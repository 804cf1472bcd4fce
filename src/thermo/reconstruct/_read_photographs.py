"""Photographs and masks from the files that cameras name."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from jaxtyping import Float
from PIL import Image, UnidentifiedImageError

from thermo.errors import InputError
from thermo.imaging import View

from ._photograph import Photograph

_ENDINGS: Final = ("", ".png", ".jpg", ".jpeg", ".JPG", ".PNG", ".tif", ".tiff")
"""What a name may lack: some files of cameras leave endings out."""
_CUT_OUT: Final = 0.99
"""An alpha channel with less in at least one pixel is a mask [1]; others only fill a format."""


def read_photographs(
    views: Sequence[View],
    folder: Path,
    *,
    masks: Path | None = None,
) -> tuple[Photograph, ...]:
    """Read what each camera saw.

    Pixels stay as they are stored: pictures are neither turned by what their header says nor
    scaled, since cameras were calibrated on what is stored. Grey pictures are grey in all channels.

    Arguments:

    - `views`: cameras with the names of their pictures.
    - `folder`: where the pictures lie, under those names or their last part.
    - `masks`: folder of masks, bright on the object, called as the pictures. None takes the
      pictures' alpha channel where one cuts anything out.

    Raises `InputError` for pictures and masks that are missing, cannot be read or have another
    size than their camera.
    """
    return tuple(_read(view, number, folder, masks) for number, view in enumerate(views))


def _read(view: View, number: int, folder: Path, masks: Path | None) -> Photograph:
    if not view.file:
        raise InputError(
            "this camera names no picture", where=f"cameras: {view.camera.name}",
            value=f"camera {number + 1}", limit="a picture for each camera",
            remedy="add file_path to its entry in the file of cameras",
        )  # fmt: skip
    path = _found(folder, view.file, "picture", "images=FOLDER")
    with _opened(path) as picture:
        values = _values(picture)
    colour, alpha = values[..., :3], values[..., 3]
    mask = alpha if alpha.min(initial=1.0) < _CUT_OUT else None
    if masks is not None:
        where = _found(masks, view.file, "mask", "masks=FOLDER")
        with _opened(where) as picture:
            shape = _values(picture)
        # A mask may be drawn in colour, or be the alpha channel of a cut-out.
        mask = shape[..., :3].max(axis=2) * shape[..., 3]
    return Photograph(view.camera, colour, mask, view.file)


def _found(folder: Path, name: str, what: str, setting: str) -> Path:
    """The file of that name, with whatever folders and ending the cameras' file has for it."""
    last = Path(name).name
    stems = [folder / name, folder / last]
    if what == "mask":
        # COLMAP puts its own ending behind the picture's.
        stems += [folder / f"{last}.png", (folder / last).with_suffix("")]
    for stem in stems:
        for ending in _ENDINGS:
            path = stem.with_name(stem.name + ending)
            if path.is_file():
                return path
    raise InputError(
        f"this {what} is not there", where=str(folder / name), value="no such file",
        limit=f"a {what} for each camera", remedy=f"give {setting}, where they lie",
    )  # fmt: skip


def _opened(path: Path) -> Image.Image:
    try:
        picture = Image.open(path)
        picture.load()
    except (OSError, SyntaxError, UnidentifiedImageError, Image.DecompressionBombError) as error:
        raise InputError(
            "this picture cannot be read", where=str(path),
            value=f"{type(error).__name__}: {error}", limit="PNG, JPEG, TIFF or what Pillow reads",
            remedy="copy it anew, or convert it",
        ) from error  # fmt: skip
    return picture


def _values(picture: Image.Image) -> Float[np.ndarray, "rows columns 4"]:
    """Red, green, blue and alpha, 0 to 1 [1]."""
    if picture.mode.startswith("I") or picture.mode == "F":
        grey = np.asarray(picture, float)
        # Sixteen bits in whichever mode; floats are taken to be shares already.
        grey = np.clip(grey if picture.mode == "F" else grey / 65535.0, 0.0, 1.0)
        return np.stack([grey, grey, grey, np.ones_like(grey)], axis=2)
    return np.asarray(picture.convert("RGBA"), float) / 255.0
