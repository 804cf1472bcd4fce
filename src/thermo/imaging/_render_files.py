"""Files that are whole or absent."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from thermo.errors import InputError


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A temporary name in the folder of `path`, which becomes `path` on success.

    The folder is made where it is missing. After an error nothing of the new file is left, and an
    older file at `path` stands as it was. Raises `InputError` where it cannot be written.
    """
    # The random part keeps two runs that write to one folder apart.
    name = f".{path.name}.{os.getpid()}.{secrets.token_hex(4)}{path.suffix}"
    temporary = path.with_name(name)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(
            "cannot write", where=str(path),
            value=f"{type(error).__name__}: {error.strerror or error}",
            limit="a folder that can be written to, with room on the disk",
            remedy="choose another place, or change its permissions",
        ) from error  # fmt: skip
    finally:
        try:
            temporary.unlink(missing_ok=True)
        except OSError:  # a folder that is none: the error above says so
            pass
