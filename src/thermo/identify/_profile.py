"""How far one unknown can go while the others make up for it: the profile likelihood."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.identify._bounds import Bounds, checked_bounds
from thermo.identify._path import LEVEL, Model, Path, Point, follow, settle

Kind = Literal["bounded", "one-sided", "flat", "at bound", "multimodal", "failed"]

LOWER: Final = 0.01
"""Fall of chi squared [1] from which a path is said to have found a better optimum."""

RESTARTS: Final = 3
"""How often a better optimum may start the profile anew [1]."""

APART: Final = 0.2
"""Relative difference of half-widths [1] from which the linear interval is not to be trusted."""

_AT_BOUND: Final = 1e-6


@final
@dataclass(frozen=True)
class Profile:
    """The least chi squared for each value of one unknown.

    - `best`: all unknowns at the optimum, (unknowns,) [1].
    - `values`, `rises`: along the path, in rising order, chi squared above its least [1];
      `remainders`: what of it the others could still take off at each point [1].
    - `lower`, `upper`: where the rise passes the level; None where the path ends before, which is
      no end point [1].
    - `linear`: half-width that the curvature at the optimum gives, infinite where it has none [1].
    - `kind`: "bounded"; "one-sided" where one end is reached; "flat" where none is; "at bound"
      where the optimum lies on one and the other side has an end; "multimodal" where the path falls
      again; "failed" where the others were not at their optimum.
    """

    best: Float[np.ndarray, " unknowns"]
    values: Float[np.ndarray, " points"]
    rises: Float[np.ndarray, " points"]
    remainders: Float[np.ndarray, " points"]
    lower: float | None
    upper: float | None
    linear: float
    kind: Kind

    def optimum(self) -> float:
        """Where the rise is least [1]."""
        return float(self.values[int(np.argmin(self.rises))])

    def nonlinear(self) -> bool:
        """Whether an end that was reached lies off the linear one by more than a fifth."""
        middle = self.optimum()
        halves = [abs(end - middle) for end in (self.lower, self.upper) if end is not None]
        return any(abs(half / self.linear - 1) > APART for half in halves)


def profile(
    model: Model,
    start: Float[np.ndarray, " unknowns"],
    number: int,
    *,
    bounds: Bounds | None = None,
    level: float = LEVEL,
) -> Profile:
    """min over the others of |r(u)|^2, for values of one unknown on both sides of the best.

    Arguments:

    - `model`: whitened residual, priors included, and its Jacobian, at unknowns [1].
    - `start`: near the optimum, which is sought first (unknowns,) [1].
    - `bounds`: of the unknowns, none by default (unknowns, 2) [1].
    - `level`: rise of chi squared at the ends of the interval [1], 3.84 for 95 %.

    Steps are laid for equal rises of chi squared, each begins where the curvature expects the
    others, and ends where nothing more is to be gained. A better optimum on the way begins
    everything anew.

    Raises `InputError` where there is no unknown of that number, and for bounds that are not a pair
    for each unknown or leave no room.

    Source: Raue et al., Bioinformatics 25 (2009) 1923.
    """
    start = np.asarray(start, float)
    if not 0 <= number < len(start):
        raise InputError(
            "there is no such unknown", where="number", value=number,
            limit=f"0 to {len(start) - 1}", remedy="number the unknowns from 0",
        )  # fmt: skip
    limits = checked_bounds(bounds, len(start))
    at = settle(model, start, limits)
    for _ in range(RESTARTS + 1):
        paths = [follow(model, at, number, way, limits, level) for way in (-1, 1)]
        lowest = min((point for path in paths for point in path.points), key=_height, default=at)
        if lowest.chi2 >= at.chi2 - LOWER:
            break
        at = settle(model, lowest.unknowns, limits)
    return _profile(at, number, paths, limits[number], level)


def _height(point: Point) -> float:
    return point.chi2


def _profile(
    at: Point, number: int, paths: list[Path], bounds: Float[np.ndarray, " 2"], level: float
) -> Profile:
    below, above = paths
    points = [*reversed(below.points), at, *above.points]
    rises = np.array([point.chi2 - at.chi2 for point in points])
    stiffness = at.stiffness(number)
    return Profile(
        best=at.unknowns,
        values=np.array([point.unknowns[number] for point in points]),
        rises=rises,
        remainders=np.array([point.remainder for point in points]),
        lower=below.end,
        upper=above.end,
        linear=float(np.sqrt(level / stiffness)) if stiffness > 0 else np.inf,
        kind=_kind(at, number, paths, bounds),
    )


def _kind(at: Point, number: int, paths: list[Path], bounds: Float[np.ndarray, " 2"]) -> Kind:
    if not at.settled() or any(not point.settled() for path in paths for point in path.points):
        return "failed"
    if any(path.falls() for path in paths):
        return "multimodal"
    reached = sum(path.end is not None for path in paths)
    value = at.unknowns[number]
    # Where the data tell no value within the bounds from another, it is chance which is the best.
    if reached and min(abs(value - bound) for bound in bounds) < _AT_BOUND:
        return "at bound"
    return ("flat", "one-sided", "bounded")[reached]
