"""Pieces of a search that are finished, kept in a folder so that an interrupted one goes on."""

from __future__ import annotations

import contextlib
import inspect
import sys
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Final, final

import numpy as np

from thermo import errors
from thermo.discover._candidate import Candidate
from thermo.discover._fingerprint import fingerprint
from thermo.errors import InputError
from thermo.observe import read_npz, write_whole

# Programs of others whose version may change the last digit of a piece.
_OTHERS: Final = ("jax", "jaxlib", "equinox", "numpy", "scipy")
_ENDING: Final = ".piece.npz"


@final
@dataclass(frozen=True)
class Memory:
    """What a search has worked out before, by all that it follows from.

    - `folder`: where each piece is a file, written whole or not at all; None keeps nothing.
    - `asked`: stands for this package, others and the candidates' own code.
    - `spared`: how long each piece that was found again had taken [s].
    - `latest`: of each kind that is asked for `lately`, the last piece and what it follows from.

    A piece is found by a hash of everything that it was made from. One of another question is
    never taken for one of this, and one that is damaged is made anew. Where the folder takes no
    file the search goes on without.
    """

    folder: Path | None = None
    asked: str = ""
    spared: list[float] = field(default_factory=list)
    latest: dict[str, tuple[str, list[np.ndarray]]] = field(default_factory=dict)

    def recalled(
        self, kind: str, of: object, make: Callable[[], Iterable[np.ndarray]]
    ) -> list[np.ndarray]:
        """The arrays that `make` returns, in whatever unit, or those that it once returned.

        Arguments: `kind`: of piece, in a word; `of`: all that the arrays depend on.
        """
        if self.folder is None:
            return _plain(make())
        key = fingerprint(self.asked, kind, of)
        file = self.folder / f"{kind}-{key}{_ENDING}"
        found = _read(file, key)
        if found is not None:
            seconds, arrays = found
            self.spared.append(seconds)
            return arrays
        begun = time.monotonic()
        arrays = _plain(make())
        _write(file, key, time.monotonic() - begun, arrays)
        return arrays

    def lately(
        self, kind: str, of: object, make: Callable[[], Iterable[np.ndarray]]
    ) -> list[np.ndarray]:
        """As `recalled`, without a folder as well where it was the last piece of its kind."""
        key = fingerprint(self.asked, kind, of)
        kept = self.latest.get(kind)
        if kept is None or kept[0] != key:
            kept = key, self.recalled(kind, of, make)
            self.latest[kind] = kept
        return kept[1]


def memory_of(folder: Path | None, candidates: Iterable[Candidate]) -> Memory:
    """The memory of a search among candidates in a folder; None keeps nothing."""
    if folder is None:
        return Memory()
    others = [(name, version(name)) for name in _OTHERS]
    return Memory(folder, fingerprint(others, _own(), [_code(type(one)) for one in candidates]))


def forget(folder: Path) -> None:
    """Remove all pieces, and the folder if nothing else lies in it."""
    # A process that was ended in the middle of a file has left a hidden one.
    for file in (*folder.glob(f"*{_ENDING}"), *folder.glob(f".*{_ENDING}.*")):
        file.unlink(missing_ok=True)
    # Something of another hand may lie there.
    with contextlib.suppress(OSError):
        folder.rmdir()


def _plain(arrays: Iterable[np.ndarray]) -> list[np.ndarray]:
    # As a file gives them back: in another order of memory sums would round otherwise.
    return [np.ascontiguousarray(one) for one in arrays]


def _read(file: Path, key: str) -> tuple[float, list[np.ndarray]] | None:
    """How long a piece took [s] and its arrays, or None where there is no such piece."""
    try:
        told = read_npz(file, required=("key", "seconds", "count"))
        if str(told["key"]) != key:
            return None
        labels = [f"part_{number:04d}" for number in range(int(told["count"]))]
        arrays = read_npz(file, required=labels)
        return float(told["seconds"]), [arrays[label] for label in labels]
    except (InputError, OSError, TypeError, ValueError):
        return None


def _write(file: Path, key: str, seconds: float, arrays: list[np.ndarray]) -> None:
    parts = {f"part_{number:04d}": one for number, one in enumerate(arrays)}
    told = {"key": np.asarray(key), "seconds": np.asarray(seconds), "count": np.asarray(len(parts))}
    with contextlib.suppress(InputError), write_whole(file) as temporary:
        np.savez(temporary, allow_pickle=False, **told, **parts)


def _own() -> list[str]:
    """The text of this package: a copy that somebody works on has one version all the time."""
    root = Path(errors.__file__).parent
    return [file.read_text("utf-8") for file in sorted(root.rglob("*.py"))]


def _code(kind: type) -> str:
    """The name of a candidate's class, and the text of the module that it stands in."""
    name = f"{kind.__module__}.{kind.__qualname__}"
    try:
        return name + inspect.getsource(sys.modules[kind.__module__])
    except (KeyError, OSError, TypeError):
        # Typed into a session, it has no file.
        return name
