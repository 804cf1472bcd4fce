"""An output folder, kept to one process at a time."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from ..errors import InputError

try:
    import fcntl
except ImportError:  # not every system has these locks
    fcntl = None

_FILE: Final = ".in_use"


@contextmanager
def claimed(folder: Path) -> Iterator[None]:
    """Keep other processes that claim it out of a folder, from within to the end.

    The system gives the claim up with the process that holds it, however that ends: what it leaves
    then is a file that claims nothing. Where the system or the disk knows no such locks nobody is
    kept out.

    Raises `InputError` where another process holds the folder.
    """
    if fcntl is None:
        yield
        return
    path = Path(folder) / _FILE
    handle = _taken(path)
    try:
        yield
    finally:
        # First the name, then the lock: who opened the file meanwhile sees that it is gone.
        path.unlink(missing_ok=True)
        os.close(handle)


def _taken(path: Path) -> int:
    """The open file, locked."""
    while True:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            if not _locked(handle):
                raise _refusal(path, os.read(handle, 100).decode("utf-8", "replace"))
            if _same(handle, path):
                os.truncate(handle, 0)
                os.write(handle, f"process {os.getpid()}".encode())
                return handle
        except BaseException:
            os.close(handle)
            raise
        # Its holder removed it between the two lines above.
        os.close(handle)


def _locked(handle: int) -> bool:
    assert fcntl is not None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a disk without locks
        return True
    return True


def _same(handle: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(handle), path.stat())
    except FileNotFoundError:
        return False


def _refusal(path: Path, holder: str) -> InputError:
    return InputError(
        "another process works in this folder",
        where="out",
        value=f"{path.parent}, held by {holder or 'another process'}",
        limit="one process a folder",
        remedy="wait until it has ended, or give another folder with out=FOLDER",
    )
