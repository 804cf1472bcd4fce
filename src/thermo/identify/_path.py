"""One side of a profile: points at which the others have settled, laid for equal rises."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jaxtyping import Float

from thermo.identify._boxed_step import boxed_step, reduced

Model = Callable[
    [Float[np.ndarray, " unknowns"]],
    tuple[Float[np.ndarray, " values"], Float[np.ndarray, "values unknowns"]],
]
"""Whitened residual and its Jacobian at unknowns [1]."""

LEVEL: Final = 3.841458820694124
"""The 95 % point of chi squared with one degree of freedom [1]."""

POINTS_A_SIDE: Final = 6
"""Rises of chi squared between the optimum and the end [1]."""

MOST_POINTS: Final = 60
"""Points of a side [1] after which it is given up as not reached."""

LONGEST: Final = 1.0
"""Longest step along the path [1], about a factor e."""

SETTLED: Final = 1e-3
"""What a step promises to take off chi squared [1] when the others have settled."""

UNSETTLED: Final = 0.05
"""Promise [1] above which the others are not at their optimum."""

FALL: Final = 0.1
"""Fall of chi squared along a path [1] from which it has more than one valley."""

# A longer step up [1] than any value can make.
_LONG: Final = 50.0
_ITERATIONS: Final = 25
_HALVINGS: Final = 8


@final
@dataclass(frozen=True)
class Point:
    """Unknowns [1] with the residual [1] and its Jacobian [1] there.

    - `remainder`: what another step of those that are free promises to take off chi squared [1].
    """

    unknowns: Float[np.ndarray, " unknowns"]
    residual: Float[np.ndarray, " values"]
    jacobian: Float[np.ndarray, "values unknowns"]
    remainder: float

    @property
    def chi2(self) -> float:
        """Sum of squares of the residual [1]."""
        return float(self.residual @ self.residual)

    def settled(self) -> bool:
        """Whether those that are free are at their optimum."""
        return self.remainder < UNSETTLED

    def others(self, number: int) -> Float[np.ndarray, " unknowns"]:
        """How the others follow when the unknown `number` moves by one [1]."""
        free = np.arange(len(self.unknowns)) != number
        way = np.zeros(len(self.unknowns))
        way[number] = 1.0
        wide = np.full((len(way) - 1, 2), [-np.inf, np.inf])
        way[free], _ = boxed_step(self.jacobian[:, number], self.jacobian[:, free], wide)
        return way

    def stiffness(self, number: int) -> float:
        """Half the curvature of chi squared along the path [1]."""
        along = self.jacobian @ self.others(number)
        return float(along @ along)


@final
@dataclass(frozen=True)
class Path:
    """Points [1] from the optimum outward, and where the level is passed, None where it is not."""

    points: list[Point]
    end: float | None
    least: float

    def falls(self) -> bool:
        """Whether chi squared falls again on the way."""
        heights = np.array([self.least, *(point.chi2 for point in self.points)])
        return bool(np.any(np.maximum.accumulate(heights) - heights > FALL))


def _promise(
    slopes: tuple[Float[np.ndarray, " few"], Float[np.ndarray, "few unknowns"]],
    room: Float[np.ndarray, "unknowns 2"],
) -> float:
    """What the slopes promise to take off chi squared within the bounds [1].

    The unknowns are logarithms, and a residual is straight in some of them and in the values of
    others: in a value that is all but gone a step up is long. The longer room counts.
    """
    longer = np.stack([room[:, 0], np.expm1(np.minimum(room[:, 1], _LONG))], axis=1)
    return boxed_step(*slopes, longer)[1]


def settle(
    model: Model,
    unknowns: Float[np.ndarray, " unknowns"],
    bounds: Float[np.ndarray, "unknowns 2"],
    held: int | None = None,
) -> Point:
    """Where Gauss-Newton steps, shortened until they help, take the unknowns not held [1].

    A box limits the step of each unknown by itself: one that hardly matters and is far from its
    optimum does not hold up the others.
    """
    unknowns = np.clip(unknowns, *bounds.T)
    here, remainder, reach = model(unknowns), np.inf, LONGEST
    for _ in range(_ITERATIONS):
        height = float(here[0] @ here[0])
        room = bounds - unknowns[:, None]
        room[np.arange(len(unknowns)) == held] = 0.0
        slopes = reduced(*here)
        remainder = _promise(slopes, room)
        near = boxed_step(*slopes, np.clip(room, -LONGEST, LONGEST))[1]
        # A little that is left far along a flat valley is not worth the way there.
        if near < SETTLED and remainder < UNSETTLED:
            break
        for _ in range(_HALVINGS):
            step, _ = boxed_step(*slopes, np.clip(room, -reach, reach))
            there = model(unknowns + step)
            if float(there[0] @ there[0]) < height:
                break
            reach = float(np.abs(step).max()) / 2
        else:
            break
        # Rounding must not carry an unknown past its bound.
        unknowns, here = np.clip(unknowns + step, *bounds.T), there
        reach = min(2 * reach, LONGEST)
    return Point(unknowns, *here, remainder)


def _length(point: Point, number: int, way: int, rise: float) -> float:
    """How far to go [1] for a rise of chi squared [1], as slope and curvature have it."""
    along = point.jacobian @ point.others(number)
    slope, stiff = way * float(along @ point.residual), float(along @ along)
    if stiff == 0.0:
        return LONGEST
    root = np.sqrt(max(slope, 0.0) ** 2 + stiff * rise)
    return float(min((root - max(slope, 0.0)) / stiff, LONGEST))


def follow(
    model: Model,
    at: Point,
    number: int,
    way: int,
    bounds: Float[np.ndarray, "unknowns 2"],
    level: float,
) -> Path:
    """Points on one side of an optimum, until chi squared has risen by `level` [1] or a bound.

    `number` is the unknown that is led, `way` is 1 up and -1 down.
    """
    points: list[Point] = []
    before, bound = at, bounds[number, 0 if way < 0 else 1]
    while len(points) < MOST_POINTS:
        room = way * (bound - before.unknowns[number])
        if room <= 0:
            return Path(points, None, at.chi2)
        length = min(_length(before, number, way, level / POINTS_A_SIDE), room)
        guess = before.unknowns + way * length * before.others(number)
        here = settle(model, guess, bounds, number)
        points.append(here)
        if here.chi2 - at.chi2 >= level:
            return Path(points, _passed(at, before, here, number, level), at.chi2)
        before = here
    return Path(points, None, at.chi2)


def _passed(at: Point, before: Point, here: Point, number: int, level: float) -> float:
    """Where the rise is `level`: its root is all but straight between two points [1]."""
    low, high = (np.sqrt(max(point.chi2 - at.chi2, 0.0)) for point in (before, here))
    share = (np.sqrt(level) - low) / (high - low)
    near, far = before.unknowns[number], here.unknowns[number]
    return float(near + share * (far - near))
