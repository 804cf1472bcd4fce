"""JSON files, read with messages that name them and written whole or not at all."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any

from thermo.errors import InputError


def read_table(path: Path, *, what: str) -> dict[str, Any]:
    """The table in a JSON file. Raises `InputError` where it is absent or holds none."""
    try:
        table = json.loads(path.read_text("utf-8"))
    except FileNotFoundError:
        raise _refusal(path, what, "no such file") from None
    except (OSError, ValueError, RecursionError) as error:
        raise _refusal(path, what, f"{type(error).__name__}: {error}") from error
    if not isinstance(table, dict):
        raise _refusal(path, what, f"a {type(table).__name__}")
    return table


def write_table(path: Path, table: dict[str, Any]) -> None:
    """Write a table. Raises `InputError` where the folder takes no file."""
    text = json.dumps(table, indent=1) + "\n"
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}.", suffix=".tmp")
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as stream:
                stream.write(text)
            os.chmod(name, 0o644)  # mkstemp makes files that only their owner may read
            os.replace(name, path)
        finally:
            Path(name).unlink(missing_ok=True)
    except OSError as error:
        raise InputError(
            "the file cannot be written", where=str(path), value=error.strerror or str(error),
            limit="a folder that takes files", remedy="give another folder",
        ) from error  # fmt: skip


def _refusal(path: Path, what: str, value: str) -> InputError:
    return InputError(
        f"{what} cannot be read", where=str(path), value=value[:200],
        limit="a JSON file that holds a table", remedy="check the name, or export it again",
    )  # fmt: skip
