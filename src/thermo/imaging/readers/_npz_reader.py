"""NumPy's archives: frames, their times, what is valid and the unit."""

from __future__ import annotations

from pathlib import Path
from typing import final

from thermo.imaging._frames import Frames
from thermo.observe import npz_array, open_npz

from ._named_arrays import NamedArrays, frames_from
from ._reader import AbstractReader
from ._stated import Stated


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
        with open_npz(path) as archive:
            names = tuple(sorted(archive.files))
            found = NamedArrays(path, names, lambda name: npz_array(path, archive, name))
            unit = str(npz_array(path, archive, "unit")) if "unit" in names else None
            return frames_from(found, given, unit=unit)
