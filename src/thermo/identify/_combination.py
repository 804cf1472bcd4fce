"""Directions among unknowns that data do not tell apart, in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final, final

import numpy as np
from jaxtyping import Float

_NOTHING: Final = 0.02
"""Exponents up to this one [1] are left out: a factor of two there is 1.4 %."""

_SIMPLE: Final = 4
"""Largest denominator of an exponent that is written as a fraction [1]."""


@final
@dataclass(frozen=True)
class Combination:
    """A change of several unknowns that leaves the data as they are.

    - `weights`: by name, the exponent of a common factor [1]; the largest is about 1.
    """

    weights: dict[str, float]

    def words(self) -> str:
        """What is free and what is still determined, as a sentence without its full stop."""
        names, exponents = list(self.weights), list(self.weights.values())
        if len(names) == 1:
            return f"{names[0]} is not determined"
        if max(exponents) - min(exponents) < _NOTHING:
            return (
                f"{listed(names)} may all be multiplied by one factor: "
                "only their ratios are determined"
            )
        first, *others = sorted(names, key=lambda name: -abs(self.weights[name]))
        lead = self.weights[first]
        powers = [f"{name} by f^{_exponent(self.weights[name] / lead)}" for name in others]
        return f"{first} may be multiplied by any factor f together with {listed(powers)}"


def combinations(
    names: tuple[str, ...], directions: Float[np.ndarray, "unknowns directions"]
) -> list[Combination]:
    """The simplest vectors that span the directions.

    They come from Gauss-Jordan elimination with full pivoting, so that each unknown that leads one
    vector is in no other.

    Arguments: `directions`: changes of log(phi), in columns [1].
    """
    rows = np.array(directions, float).T
    leads: list[int] = []
    for number in range(len(rows)):
        left = np.abs(rows[number:])
        left[:, leads] = 0.0
        best, column = np.unravel_index(np.argmax(left), left.shape)
        if left[best, column] == 0.0:
            return _named(names, rows[:number])
        rows[[number, number + best]] = rows[[number + best, number]]
        rows[number] /= rows[number, column]
        others = np.arange(len(rows)) != number
        rows[others] -= np.outer(rows[others, column], rows[number])
        leads.append(int(column))
    return _named(names, rows)


def _named(
    names: tuple[str, ...], rows: Float[np.ndarray, "vectors unknowns"]
) -> list[Combination]:
    found = []
    for row in rows:
        # Of exponents that are alike the first leads, whatever rounding says.
        size = np.abs(row)
        scaled = row / row[np.argmax(size > (1 - _NOTHING) * size.max())]
        kept = {
            name: float(value)
            for name, value in zip(names, scaled, strict=True)
            if abs(value) > _NOTHING
        }
        found.append(Combination(kept))
    return found


def _exponent(value: float) -> str:
    simple = Fraction(value).limit_denominator(_SIMPLE)
    return str(simple) if abs(float(simple) - value) < _NOTHING else f"{value:.2f}"


def listed(words: Sequence[str]) -> str:
    """One phrase of all words, the last after an `and`."""
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]
