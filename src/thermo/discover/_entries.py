"""Which entries of a point belong to each candidate, and in what bounds they are free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import jax
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from thermo.discover._candidate import (
    SHARPNESS,
    SQUARENESS,
    Candidate,
    Card,
    Inclusion,
    Place,
    Transition,
    Where,
    with_edge,
)
from thermo.discover._descent import Free
from thermo.discover._extended import Extended, numbers
from thermo.inverse import Parameters

# A place's size is at most so many times the first [1]; a field's logarithm moves by this [1].
_LARGER, _FIELD = 4.0, 0.3
# What has an edge in place of a bell may be so many times as small as that at the least [1].
_THIN = 0.1
# A transition stays within so many of its first widths of where it is looked for at first [1].
_WIDTHS = 3.0
# Axes along which a place is held [1].
_NONE: Final = np.zeros(3, bool)
# Logarithm of how far below its first value a coefficient is brought back at once [1].
_FAR = 10.0


Few = Float[np.ndarray, " few"]

Active = tuple[str, int]
"""A part of a candidate that is at work: the candidate's name, the part's number [1]."""


@final
@dataclass(frozen=True)
class Entry:
    """One part of a candidate: a place, an axis, or all strengths that belong together.

    - `kind`: number of the candidate in its tuple [1]; `part`: of its strengths [1].
    - `card`; `strengths`: numbers of its entries in the flattened point, (strengths,) [1].
    """

    kind: int
    part: int
    card: Card
    strengths: Int[np.ndarray, " strengths"]


def entries(point: Extended) -> list[Entry]:
    """Every part of every candidate, in the order of the flattened point."""
    at = numbers(point).at
    found = []
    for kind, (one, where) in enumerate(zip(point.candidates, at.candidates, strict=True)):
        place = np.asarray(where.strength).astype(int)
        if one.card.joint:
            found.append(Entry(kind, 0, one.card, place))
        else:
            found += [Entry(kind, part, one.card, place[[part]]) for part in range(len(place))]
    return found


def field_entries(point: Extended, first: Parameters) -> Free:
    """The parameters of the fields, free; `first`: where the scene puts them [1].

    A gap may draw a coefficient far down, where its logarithm hardly shows in the readings: what
    is a large change is one of the first value then.
    """
    number = _flat(numbers(point).at.fields).astype(int)
    wide = np.full(len(number), np.inf)
    above = np.maximum(_flat(first) - _flat(point.fields), 0.0)
    scale = _FIELD * np.exp(np.minimum(above, _FAR))
    return Free(number, scale, -wide, wide, np.ones(len(number), bool))


def _flat(fields: Parameters) -> Float[np.ndarray, " entries"]:
    return np.concatenate([np.asarray(leaf).ravel() for leaf in jax.tree.leaves(fields)])


def entry_of(point: Extended, active: Active) -> Entry:
    """The part of a candidate [1] by the candidate's name and the part's number."""
    name, part = active
    return next(one for one in entries(point) if one.card.name == name and one.part == part)


def free_entries(
    point: Extended,
    entry: Entry,
    before: Candidate,
    corners: Float[np.ndarray, "2 3"],
    held: Bool[np.ndarray, "3"] = _NONE,
) -> Free:
    """The strengths, places and sizes of a part of a candidate, each in its unit.

    Arguments: `before`: the candidate with its places of the first size [m, or K]; `corners`: of
    the body's box [m]; `held`: axes along which a patch with an edge neither moves nor grows [1].
    """
    card, at = entry.card, numbers(point).at.candidates[entry.kind]
    count = len(entry.strengths)
    parts = [
        Free(
            entry.strengths,
            np.full(count, 0.5 * card.typical),
            np.full(count, card.low),
            np.full(count, card.high),
            np.zeros(count, bool),
        )
    ]
    smallest = card.smallest
    if isinstance(at.place, Inclusion) and isinstance(before.place, Place):
        # Across a skin an even patch may be as thin as the body is there.
        before, smallest = with_edge(before), _THIN * smallest
    if before.place is not None and at.place is not None:
        parts += _of_place(at.place, before.place, entry.part, corners, smallest)
    free = joined(*parts)
    if not held.any() or not isinstance(at.place, Inclusion):
        return free
    still = np.asarray([at.place.centre[entry.part], at.place.size[entry.part]])[:, held]
    return free.but(still.astype(int))


def _of_place(
    numbers: Where,
    before: Where,
    part: int,
    corners: Float[np.ndarray, "2 3"],
    smallest: float,
) -> list[Free]:
    """Where a part is [m, or K], how wide and of what form, free.

    `numbers`: of all entries [1]; `smallest`: size over the first one [1].
    """

    def of(leaf: Array) -> Few:
        return np.atleast_1d(np.asarray(leaf)[part])

    def free(leaf: Array, scale: Few, low: Few, high: Few) -> Free:
        return Free(of(leaf).astype(int), scale, low, high, np.zeros(len(scale), bool))

    sizes = of(before.size)
    found = [free(numbers.size, 0.5 * sizes, smallest * sizes, _LARGER * sizes)]
    where = numbers.centre
    if where is None:
        return found
    if isinstance(before, Transition):
        middle, far = of(before.centre), _WIDTHS * sizes
        return [free(where, sizes, middle - far, middle + far), *found]
    if isinstance(numbers, Inclusion):
        for leaf, (first, least, most) in (
            (numbers.squareness, SQUARENESS),
            (numbers.sharpness, SHARPNESS),
        ):
            found.append(free(leaf, *(np.array([one]) for one in (0.5 * first, least, most))))
    return [free(where, np.array(np.broadcast_to(sizes, 3)), *corners), *found]


def joined(*parts: Free) -> Free:
    """All entries that any of the parts holds [1]."""
    return Free(
        np.concatenate([one.number for one in parts]),
        np.concatenate([one.scale for one in parts]),
        np.concatenate([one.low for one in parts]),
        np.concatenate([one.high for one in parts]),
        np.concatenate([one.logarithm for one in parts]),
    )
