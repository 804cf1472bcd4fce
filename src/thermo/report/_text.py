"""Plain text files."""

from __future__ import annotations

from pathlib import Path

from thermo.observe import write_whole


def write_text(path: Path, text: str) -> None:
    """Writes text as UTF-8, whole or not at all; the folder is made if it is missing."""
    with write_whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="")
