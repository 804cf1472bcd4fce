"""NPZ archives, read without ever unpickling and written atomically."""

from __future__ import annotations

import difflib
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from thermo.errors import InputError

from ._atomic import write_whole

# Everything that numpy and zipfile raise on a damaged or hostile archive.
_BROKEN = (
    ValueError, OSError, EOFError, KeyError, SyntaxError, MemoryError, RuntimeError,
    zipfile.BadZipFile, zlib.error,
)  # fmt: skip


def read_npz(
    path: Path, *, required: Sequence[str], optional: Sequence[str] = ()
) -> dict[str, np.ndarray]:
    """Return the named arrays of an NPZ file, of any shape and unit, say [K] or [s].

    Other names are left unread, unless one looks like a misspelt optional name.

    Raises `InputError` if the file is absent, truncated or no NPZ, lacks a required array, or
    holds a pickled object array.
    """
    with open_npz(path) as archive:
        names = list(archive.files)
        _check_names(path, names, required, optional)
        return {n: npz_array(path, archive, n) for n in (*required, *optional) if n in names}


@contextmanager
def open_npz(path: Path) -> Iterator[np.lib.npyio.NpzFile]:
    """An NPZ archive whose arrays `npz_array` reads one by one, closed in the end.

    Raises `InputError` if the file is absent, truncated or no NPZ; within it too.
    """
    check_file(path)
    if not zipfile.is_zipfile(path):
        raise _damaged(path, "no readable zip directory in it")
    try:
        # A stream of our own is closed even where the archive cannot be opened.
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            yield archive
    except InputError:
        raise
    except _BROKEN as error:
        raise _damaged(path, f"{type(error).__name__}: {error}") from error


def npz_array(path: Path, archive: np.lib.npyio.NpzFile, name: str) -> np.ndarray:
    """One array of an open archive, of any shape and unit, say [K] or [s], as it is stored.

    Raises `InputError` where it holds pickled objects.
    """
    try:
        return archive[name]
    except ValueError as error:
        if "pickle" not in str(error).lower():
            raise
        raise InputError(
            "array holds pickled objects, which are never loaded", where=f"{path}: {name}",
            value="an object array", limit="an array of plain numbers",
            remedy="save it again as numbers, for example with array.astype(float)",
        ) from error  # fmt: skip


def write_npz(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    """Write arrays to `path`; the file appears whole or not at all.

    Raises `InputError` if the folder cannot be written to.
    """
    with write_whole(path, make_folder=False) as temporary, temporary.open("wb") as stream:
        np.savez_compressed(stream, allow_pickle=False, **dict(arrays))


def check_file(path: Path) -> None:
    """Raise `InputError` unless `path` is a file."""
    if not path.is_file():
        raise InputError(
            "file not found", where=str(path),
            value="a folder" if path.is_dir() else "no such file",
            limit="an existing, readable file",
            remedy="check the name and the folder; paths in scene.json are relative to its folder",
        )  # fmt: skip


def _check_names(
    path: Path, names: Sequence[str], required: Sequence[str], optional: Sequence[str]
) -> None:
    missing = [name for name in required if name not in names]
    limit = f"arrays {', '.join(required)}"
    if optional:
        limit += f"; optional {', '.join(optional)}"
    if missing:
        raise InputError(
            f"array `{missing[0]}` is missing", where=str(path),
            value=f"arrays {', '.join(sorted(names)) or '(none)'}", limit=limit,
            remedy=f"add `{missing[0]}` to the archive",
        )  # fmt: skip
    absent = [name for name in optional if name not in names]
    for name in set(names) - {*required, *optional}:
        close = difflib.get_close_matches(name, absent, n=1, cutoff=0.75)
        if close:
            raise InputError(
                f"array `{name}` is unknown", where=str(path), value=name, limit=limit,
                remedy=f"did you mean `{close[0]}`? Rename it",
            )  # fmt: skip


def _damaged(path: Path, reason: str) -> InputError:
    return InputError(
        "not a whole NPZ file", where=str(path),
        value=f"{path.stat().st_size} bytes; {' '.join(reason.split())[:120]}",
        limit="an NPZ archive (zip) as numpy.savez writes it",
        remedy="the file is truncated, damaged or of another type: copy or export it again",
    )  # fmt: skip
