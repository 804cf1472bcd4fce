"""JSON files, read with messages that name them and written whole or not at all."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from thermo.errors import InputError
from thermo.observe import write_whole


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
    with write_whole(path, make_folder=False) as temporary:
        temporary.write_text(text, "utf-8")


def _refusal(path: Path, what: str, value: str) -> InputError:
    return InputError(
        f"{what} cannot be read", where=str(path), value=value[:200],
        limit="a JSON file that holds a table", remedy="check the name, or export it again",
    )  # fmt: skip
