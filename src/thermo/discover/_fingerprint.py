"""A hash of all that a calculation depends on."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass

import jax
import numpy as np


def fingerprint(*parts: object) -> str:
    """A short text that differs wherever any array, number, text or type in `parts` differs.

    It is the same in every process: of a module or dataclass its type's name and all of its fields
    count, of an array its bits, its shape and its kind of number, of a function its name.
    """
    digest = hashlib.sha256()
    _add(digest, parts)
    return digest.hexdigest()[:32]


def _add(digest: hashlib._Hash, one: object) -> None:
    if isinstance(one, jax.Array | np.ndarray | np.generic):
        array = np.asarray(one)
        digest.update(f"array {array.dtype.str} {array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    elif is_dataclass(one) and not isinstance(one, type):
        digest.update(_name(type(one)))
        for each in fields(one):
            digest.update(f".{each.name}".encode())
            _add(digest, getattr(one, each.name))
    elif isinstance(one, Mapping):
        digest.update(f"mapping {len(one)}".encode())
        for key in sorted(one, key=repr):
            _add(digest, key)
            _add(digest, one[key])
    elif isinstance(one, list | tuple):
        digest.update(f"{type(one).__name__} {len(one)}".encode())
        for each in one:
            _add(digest, each)
    elif isinstance(one, type) or callable(one):
        digest.update(_name(one))
    else:
        digest.update(f"{type(one).__name__} {one!r};".encode())


def _name(one: object) -> bytes:
    # The text of a function would hold where it lies in memory.
    module, name = getattr(one, "__module__", ""), getattr(one, "__qualname__", repr(one))
    return f"{module}.{name}".encode()
