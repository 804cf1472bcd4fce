"""Results as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from thermo.observe import write_whole


def _plain(value: object, where: str) -> Any:
    """The value in the types that JSON knows; `where` is its dotted key."""
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        wrong = [key for key in value if not isinstance(key, str)]
        if wrong:
            raise TypeError(f"{where}: the key {wrong[0]!r} is not text")
        return {key: _plain(inner, f"{where}.{key}") for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner, f"{where}[{i}]") for i, inner in enumerate(value)]
    if isinstance(value, int):
        return int(value)
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, np.ndarray | np.generic) or hasattr(value, "__array__"):
        array = np.asarray(value)
        if array.dtype.kind in "biufU":
            return _plain(array.tolist(), where)
    raise TypeError(f"{where}: {type(value).__name__} cannot be written as JSON")


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Writes `data` as indented JSON, whole or not at all.

    Arguments:
    - `path`: the file; its folder is made if it is missing.
    - `data`: text keys; values are numbers, text, truth values, `None`, paths, arrays, and
      mappings, lists and tuples of these. Arrays of any shape become nested lists.

    JSON has no word for a number that is not finite: NaN and the infinities become `null`, so
    that one of them does not cost the result of a run.

    Raises `TypeError` with the dotted key of a value that JSON cannot hold.
    """
    text = json.dumps(_plain(data, "data"), indent=2, ensure_ascii=False, allow_nan=False)
    with write_whole(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")
