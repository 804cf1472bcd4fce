"""Unknowns whose effects look alike, and which of them to measure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, islice
from math import comb
from typing import Final, final

import numpy as np
from jaxtyping import Float

from thermo.identify._information import information, numbered
from thermo.inverse import Sensitivity

WARNED: Final = 20.0
"""Index [1] above which unknowns are called alike: the others make up for the effect of one to a
twentieth of it."""

LARGEST: Final = 4
"""Sets of up to this many unknowns are all looked at [1]."""

MOST: Final = 1_000_000
"""Sets of one size [1] beyond which none of that size is looked at: those of four of 70 unknowns,
in seconds."""

_AT_ONCE: Final = 10_000


@final
@dataclass(frozen=True)
class Alike:
    """Unknowns whose effects on the readings make up for each other.

    - `names`: of the set, of which no smaller one is alike.
    - `index`: 1 for effects at right angles; at 20 the others make up for all but a twentieth of
      the effect of one [1].
    - `measure`: the one that leaves the others the least alike once it is known.
    """

    names: tuple[str, ...]
    index: float
    measure: str


def alike(at: Sensitivity, *, model_error: float = 0.01) -> list[Alike]:
    """Smallest sets of unknowns whose effects are nearly dependent, the worst first.

    gamma = 1 / sqrt(least eigenvalue of S'S), with the columns of S those of L^-1 J at length 1,
    C = LL' the covariance of the readings. All sets of up to four are looked at, of many unknowns
    of fewer (`MOST`); where none of them is alike and all unknowns together are, unknowns are
    dropped as long as the rest is.

    Arguments:

    - `at`: slopes of the temperatures [K].
    - `model_error`: what the simulation itself may be wrong by [K].

    The index tells nothing of how large the effects are: `spectrum` does. Raises `InputError`
    where `model_error` cannot be.

    Source: Brun, Reichert and Kuensch, Water Resources Research 37 (2001) 1015, equation 13.
    """
    square = information(at, model_error)
    seen = np.flatnonzero(np.diagonal(square) > 0)
    length = np.sqrt(np.diagonal(square)[seen])
    cosines = square[np.ix_(seen, seen)] / np.outer(length, length)
    names = [numbered(at.names)[number] for number in seen]
    found: list[tuple[int, ...]] = []
    for picked in _near(cosines):
        if not any(set(smaller) <= set(picked) for smaller in found):
            found.append(picked)
    every = tuple(range(len(seen)))
    if not found and len(seen) > LARGEST and _index(cosines, every) > WARNED:
        found.append(_thinned(cosines, every))
    sets = [
        Alike(
            tuple(names[number] for number in picked),
            _index(cosines, picked),
            names[_worst(cosines, picked)],
        )
        for picked in found
    ]
    return sorted(sets, key=lambda one: -one.index)


def _near(cosines: Float[np.ndarray, "unknowns unknowns"]) -> Iterator[tuple[int, ...]]:
    """Sets whose index is too large, the smallest first; many matrices at once."""
    count = len(cosines)
    for size in range(2, min(LARGEST, count) + 1):
        if comb(count, size) > MOST:
            return
        every = combinations(range(count), size)
        while some := list(islice(every, _AT_ONCE)):
            picked = np.array(some)
            parts = cosines[picked[:, :, None], picked[:, None, :]]
            least = np.linalg.eigvalsh(parts)[:, 0]
            yield from (some[number] for number in np.flatnonzero(least < WARNED**-2))


def _index(cosines: Float[np.ndarray, "unknowns unknowns"], picked: tuple[int, ...]) -> float:
    if len(picked) < 2:
        return 1.0
    least = float(np.linalg.eigvalsh(cosines[np.ix_(picked, picked)])[0])
    # Columns that depend on each other to the last digit leave an eigenvalue of rounding.
    return 1 / np.sqrt(max(least, len(picked) * float(np.finfo(float).eps)))


def _worst(cosines: Float[np.ndarray, "unknowns unknowns"], picked: tuple[int, ...]) -> int:
    """The number without which the others are the least alike."""
    return min(picked, key=lambda one: _index(cosines, _without(picked, one)))


def _thinned(
    cosines: Float[np.ndarray, "unknowns unknowns"], picked: tuple[int, ...]
) -> tuple[int, ...]:
    """As few numbers as are alike, one dropped at a time."""
    while True:
        least = max(picked, key=lambda one: _index(cosines, _without(picked, one)))
        fewer = _without(picked, least)
        if _index(cosines, fewer) <= WARNED:
            return picked
        picked = fewer


def _without(picked: tuple[int, ...], one: int) -> tuple[int, ...]:
    return tuple(number for number in picked if number != one)
