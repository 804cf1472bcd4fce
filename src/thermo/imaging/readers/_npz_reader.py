"""NumPy's archives: frames, their times, what is valid and the unit."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path
from typing import final

import numpy as np

from thermo.errors import InputError
from thermo.imaging._frames import Frames

from ._damaged import damaged
from ._named_arrays import NamedArrays, frames_from
from ._npy_reader import unreadable
from ._reader import AbstractReader
from ._stated import Stated

_BROKEN = (
    ValueError, OSError, EOFError, KeyError, SyntaxError, MemoryError, RuntimeError,
    zipfile.BadZipFile, zlib.error,
)  # fmt: skip


@final
class NpzReader(AbstractReader):
    """`.npz`: arrays `frames` or `temperature`, and where they are there `time`, `valid`, `unit`.

    `time` (frames,) [s]; `frames` and `temperature` (frames, rows, columns); `valid` (frames, rows,
    columns) or (rows, columns), true or false; `unit` the text "K", "C" or "counts".
    """

    def format(self) -> str:
        """The files that it reads."""
        return "NPZ (arrays `frames` or `temperature`, and `time`)"

    def recognises(self, path: Path) -> bool:
        """By suffix: other formats are zip archives too."""
        return path.suffix.casefold() == ".npz" and not path.is_dir()

    def read(self, path: Path, given: Stated) -> Frames:
        """The frames [K] or [1] and their times [s]; raises `InputError`."""
        if not zipfile.is_zipfile(path):
            raise damaged(path, "NPZ file", "no readable zip directory in it")
        try:
            with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
                names = set(archive.files)
                found = NamedArrays(
                    path=path, names=tuple(sorted(names)), read=lambda name: archive[name]
                )
                return frames_from(found, given, unit=_unit(archive, names))
        except InputError:
            raise
        except _BROKEN as error:
            raise unreadable(path, "NPZ file", error) from error


def _unit(archive: np.lib.npyio.NpzFile, names: set[str]) -> str | None:
    return str(archive["unit"]) if "unit" in names else None
