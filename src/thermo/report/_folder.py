"""The output folder, checked before any work."""

from __future__ import annotations

import os
import secrets
from pathlib import Path

from ..errors import InputError


def require_writable(folder: Path) -> None:
    """Makes `folder` with its parents if it is missing, and makes sure that it takes files.

    A file is written there and removed, since permission bits do not tell of a full or read-only
    disk. Raises `InputError` where the path or a parent is a file, or nothing can be written.
    """
    folder = Path(folder)
    probe = folder / f".probe.{os.getpid()}.{secrets.token_hex(4)}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.write_bytes(b"thermo")
    except FileExistsError:
        raise _refusal(folder, "a file stands where the folder should be") from None
    except NotADirectoryError:
        raise _refusal(folder, "a parent of the folder is a file") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise _refusal(folder, f"nothing can be written there ({reason})") from error
    finally:
        # Where even this fails, the error above has told why.
        try:
            probe.unlink(missing_ok=True)
        except (OSError, ValueError):
            pass


def _refusal(folder: Path, what: str) -> InputError:
    return InputError(
        what,
        where="out",
        value=str(folder),
        limit="a folder that can be made and written to",
        remedy="give another folder with out=FOLDER, or remove what stands there",
    )
