"""NumPy's single arrays: a stack of frames."""

from __future__ import annotations

from pathlib import Path
from typing import final

import numpy as np

from thermo.errors import InputError
from thermo.imaging._frames import Frames

from ._damaged import damaged
from ._folder import first_bytes
from ._reader import AbstractReader
from ._stated import Stated
from ._values import frames_of


@final
class NpyReader(AbstractReader):
    """`.npy`: values (frames, rows, columns), or one frame (rows, columns); no stamps."""

    def format(self) -> str:
        """The files that it reads."""
        return "NPY (a stack of frames)"

    def recognises(self, path: Path) -> bool:
        """By suffix, or by NumPy's first bytes."""
        if path.is_dir():
            return False
        return path.suffix.casefold() == ".npy" or first_bytes(path, 6) == b"\x93NUMPY"

    def read(self, path: Path, given: Stated) -> Frames:
        """The frames [K] or [1] at stated times [s]; raises `InputError`."""
        try:
            with path.open("rb") as stream:
                values = np.lib.format.read_array(stream, allow_pickle=False)
        except (ValueError, OSError, EOFError, SyntaxError, MemoryError) as error:
            if "Object arrays" in str(error):
                raise objects(path) from error
            raise damaged(path, "NPY file", error) from error
        return frames_of(values, given, where=str(path))


def objects(path: Path, name: str = "") -> InputError:
    """The error for an array of Python objects, which is never loaded."""
    return InputError(
        "array holds objects, which are never loaded",
        where=f"{path}: {name}" if name else str(path), value="an object array",
        limit="an array of plain numbers, all frames of one size",
        remedy="save it again as numbers, for example with np.stack(frames).astype(np.float32)",
    )  # fmt: skip
