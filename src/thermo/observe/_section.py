"""Sections of a JSON file, so that every complaint names the file and the key."""

from __future__ import annotations

import difflib
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from thermo.errors import InputError

from ._npz import check_file
from ._number import real_array, shown


@final
@dataclass(frozen=True)
class Section:
    """One JSON object: the file it stands in, its dotted path there, and its entries."""

    file: Path
    path: str
    table: dict[str, Any]

    def where(self, key: str = "") -> str:
        """Return the file and the dotted path of `key`."""
        dotted = ".".join(part for part in (self.path, key) if part)
        return f"{self.file}: {dotted}" if dotted else str(self.file)

    def check_keys(self, required: Sequence[str], optional: Sequence[str] = ()) -> None:
        """Raise `InputError` for a key that is unknown or a required one that is missing."""
        known = (*required, *optional)
        for key in self.table:
            if key not in known:
                close = difflib.get_close_matches(key, known, n=1)
                raise InputError(
                    f"unknown key `{key}`", where=self.where(key), value=shown(self.table[key]),
                    limit=f"known keys: {', '.join(known)}",
                    remedy=f"did you mean `{close[0]}`?" if close else f"remove `{key}`",
                )  # fmt: skip
        for key in required:
            if key not in self.table:
                raise InputError(
                    f"key `{key}` is missing", where=self.where(key),
                    value=f"keys {', '.join(self.table) or '(none)'}",
                    limit=f"required keys: {', '.join(required)}", remedy=f"add `{key}`",
                )  # fmt: skip

    def section(self, key: str) -> Section:
        """Return the object under `key`; an absent one is empty."""
        value = self.table.get(key, {})
        if not isinstance(value, dict):
            raise self.wrong(key, "an object {...} with named entries")
        inner = ".".join(part for part in (self.path, key) if part)
        return Section(self.file, inner, value)

    def text(self, key: str, default: str | None = None) -> str:
        """Return the text under `key`; null, empty and absent give `default`, if there is one."""
        value = self.table.get(key)
        if default is not None and (value is None or value == ""):
            return default
        if not isinstance(value, str) or not value.strip():
            raise self.wrong(key, "a text that is not empty")
        return value

    def number(self, key: str) -> float:
        """Return the number under `key`; one too large for a float is infinite."""
        value = self.table.get(key)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.wrong(key, "a number")
        try:
            return float(value)
        except OverflowError:
            return math.inf

    def number_or_null(self, key: str) -> float | None:
        """Return the number under `key`, or None for null."""
        return None if self.table.get(key) is None else self.number(key)

    def array(self, key: str) -> np.ndarray:
        """Return the list of numbers under `key`, of whatever shape."""
        return real_array(self.items(key), where=self.where(key), quantity=f"`{key}`")

    def flag(self, key: str, default: bool) -> bool:
        """Return true or false under `key`."""
        value = self.table.get(key, default)
        if not isinstance(value, bool):
            raise self.wrong(key, "true or false, without quotation marks")
        return value

    def items(self, key: str) -> list[Any]:
        """Return the list under `key`; null and absent give an empty one."""
        value = self.table.get(key)
        if value is None:
            return []
        if not isinstance(value, list):
            raise self.wrong(key, "a list [...]")
        return value

    def wrong(self, key: str, limit: str) -> InputError:
        """Return the error for a value of the wrong type under `key`."""
        return InputError(
            f"`{key}` has the wrong type", where=self.where(key),
            value=shown(self.table.get(key)), limit=limit, remedy=f"write `{key}` as {limit}",
        )  # fmt: skip


def read_json(file: Path) -> Section:
    """Read a JSON file whose outermost value is an object.

    Raises `InputError` if it is absent, no JSON, or names a key twice.
    """
    check_file(file)

    def table(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        entries = dict(pairs)
        if len(entries) < len(pairs):
            names = [name for name, _ in pairs]
            twice = next(name for name in names if names.count(name) > 1)
            raise InputError(
                f"key `{twice}` stands twice", where=str(file), value=twice,
                limit="every key once in its object", remedy="remove one of the two",
            )  # fmt: skip
        return entries

    try:
        root = json.loads(file.read_text(encoding="utf-8-sig"), object_pairs_hook=table)
    except InputError:
        raise
    except (ValueError, OSError, RecursionError) as error:
        raise InputError(
            "not a JSON file", where=str(file), value=f"{type(error).__name__}: {error}"[:160],
            limit="JSON in UTF-8", remedy="correct the place that is named, or write it again",
        ) from error  # fmt: skip
    if not isinstance(root, dict):
        raise InputError(
            "not a JSON object", where=str(file), value=shown(root),
            limit="an object {...} with named entries", remedy="write the file as an object",
        )  # fmt: skip
    return Section(file, "", root)
