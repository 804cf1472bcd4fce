"""Files that are either whole or absent."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from thermo.errors import InputError


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Gives a temporary name in the folder of `path`, and renames it to `path` on success.

    After an error nothing of the new file is left, and an older file at `path` stands as it was.

    Arguments: `path`: the file; the temporary name has the same ending.

    Raises whatever writing raises.
    """
    path = Path(path)
    # The random part keeps two runs that write to one folder apart. Not from `tempfile`, whose
    # files only their owner may read.
    temporary = path.with_name(f".{path.name}.{os.getpid()}.{secrets.token_hex(4)}{path.suffix}")
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        try:
            temporary.unlink(missing_ok=True)
        except OSError:  # a folder that is none: the error above says so
            pass


@contextmanager
def write_whole(path: Path, *, make_folder: bool = True) -> Iterator[Path]:
    """`replacing`, with an error that says what to do.

    Arguments:

    - `path`: the file; the temporary name has the same ending.
    - `make_folder`: makes the folder where it is missing; without, a missing folder is refused.

    Raises `InputError` where the file cannot be written.
    """
    path = Path(path)
    try:
        if make_folder:
            path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as temporary:
            yield temporary
    except OSError as error:
        raise unwritable(path, error) from error


def unwritable(path: Path, error: OSError) -> InputError:
    """The error for an output path that cannot be written."""
    return InputError(
        "this cannot be written", where=str(path),
        value=f"{type(error).__name__}: {error.strerror or error}",
        limit="a folder that can be written to, with room on the disk",
        remedy="choose another output folder, or change its permissions",
    )  # fmt: skip
