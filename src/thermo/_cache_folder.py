"""Where what can be made again is kept."""

from __future__ import annotations

import os
from pathlib import Path


def cache_folder() -> Path:
    """`thermofield` in $XDG_CACHE_HOME, or in ~/.cache; raises `RuntimeError` without a home."""
    stated = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(stated) if stated else Path.home() / ".cache") / "thermofield"
