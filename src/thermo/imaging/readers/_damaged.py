"""Errors that readers of several formats share: damaged files and libraries that are absent."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType

from thermo.errors import InputError


def damaged(path: Path, kind: str, reason: object) -> InputError:
    """The error for a file that is not a whole file of its `kind`."""
    text = f"{type(reason).__name__}: {reason}" if isinstance(reason, Exception) else str(reason)
    size = f"{path.stat().st_size} bytes; " if path.is_file() else ""
    return InputError(
        f"not a whole {kind}", where=str(path), value=f"{size}{' '.join(text.split())[:160]}",
        limit=f"a {kind} as its program writes it",
        remedy="the file is truncated, damaged or of another type: copy or export it again",
    )  # fmt: skip


def library(name: str, path: Path) -> ModuleType:
    """The library `name`, which reads `path`, or `InputError` where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise InputError(
            "this format needs a library that is not installed", where=str(path), value=name,
            limit=f"{name} installed", remedy="pip install 'thermofield[cameras]'",
        ) from error  # fmt: skip
