"""What pure functions of arrays gave for the last few arguments."""

from __future__ import annotations

import functools
import hashlib
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any, ParamSpec, TypeVar

import jax
import numpy as np

Taken = ParamSpec("Taken")
Given = TypeVar("Given")


_every: list[OrderedDict[Hashable, Any]] = []


def remembered(most: int) -> Callable[[Callable[Taken, Given]], Callable[Taken, Given]]:
    """Keep what a function gave for the last `most` arguments, told apart by their content.

    A mesh that is read or made anew is the same mesh then. For functions that depend on nothing
    but their arguments, PyTrees of NumPy arrays and numbers, and whose results nobody changes.
    """

    def decorated(function: Callable[Taken, Given]) -> Callable[Taken, Given]:
        kept: OrderedDict[Hashable, Given] = OrderedDict()
        lock = threading.Lock()
        _every.append(kept)

        @functools.wraps(function)
        def run(*args: Taken.args, **kwargs: Taken.kwargs) -> Given:
            key = _content((args, kwargs))
            with lock:
                if key in kept:
                    kept.move_to_end(key)
                    return kept[key]
            # Two threads that ask for the same at once both work it out.
            given = function(*args, **kwargs)
            with lock:
                kept[key] = given
                while len(kept) > most:
                    kept.popitem(last=False)
            return given

        return run

    return decorated


def forget() -> None:
    """Drop all that is kept: for tests and measurements that change what functions depend on."""
    for kept in _every:
        kept.clear()


def _content(taken: object) -> Hashable:
    leaves, tree = jax.tree.flatten(taken)
    digest = hashlib.blake2b(digest_size=20)
    for leaf in leaves:
        array = np.ascontiguousarray(leaf)
        digest.update(repr((array.dtype.str, array.shape)).encode())
        digest.update(array.data)
    return tree, digest.digest()
