"""HDF5 files: frames, their times, what is valid and the unit."""

from __future__ import annotations

from pathlib import Path
from typing import Any, final

import numpy as np

from thermo.errors import InputError
from thermo.imaging._frames import Frames

from ._damaged import damaged, library
from ._folder import first_bytes
from ._named_arrays import FRAMES, NamedArrays, frames_from
from ._npy_reader import objects
from ._reader import AbstractReader
from ._stated import Stated

_SUFFIXES = (".h5", ".hdf5", ".hdf")
_MAGIC = b"\x89HDF\r\n\x1a\n"


@final
class Hdf5Reader(AbstractReader):
    """HDF5: datasets `frames` or `temperature`, and where they are there `time` and `valid`.

    Shapes and units are those of `NpzReader`. The unit is an attribute `unit` (or `units`) of the
    frames or of the file.
    """

    def format(self) -> str:
        """The files that it reads."""
        return "HDF5 (datasets `frames` or `temperature`, and `time`)"

    def recognises(self, path: Path) -> bool:
        """By suffix, or by the first bytes."""
        if path.is_dir():
            return False
        return path.suffix.casefold() in _SUFFIXES or first_bytes(path, 8) == _MAGIC

    def read(self, path: Path, given: Stated) -> Frames:
        """The frames [K] or [1] and their times [s]; raises `InputError`."""
        h5py = library("h5py", path)
        try:
            with h5py.File(path, "r") as file:
                names = tuple(sorted(n for n, one in file.items() if isinstance(one, h5py.Dataset)))
                arrays = NamedArrays(path=path, names=names, read=lambda n: _read(path, file[n], n))
                return frames_from(arrays, given, unit=_unit(file, arrays.frames_name()))
        except InputError:
            raise
        except (OSError, KeyError, RuntimeError, ValueError, TypeError, MemoryError) as error:
            raise damaged(path, "HDF5 file", error) from error


def _read(path: Path, dataset: Any, name: str) -> np.ndarray:
    if dataset.dtype.kind == "O":
        raise objects(path, name)
    if name not in FRAMES or dataset.dtype.kind != "f" or dataset.ndim == 0:
        return dataset[()]
    # HDF5 itself converts to single precision, so that no second copy is made.
    values = np.empty(dataset.shape, np.float32)
    if values.size:
        dataset.read_direct(values)
    return values


def _unit(file: Any, name: str) -> str | None:
    for holder in (file[name], file):
        for key in ("unit", "units"):
            if key in holder.attrs:
                value = holder.attrs[key]
                return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return None
