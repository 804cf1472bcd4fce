"""A box that picks a part of the surface."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from thermo.errors import InputError

from ._number import check_vector


@final
class Box(eqx.Module):
    """All points between two opposite corners; its sides count as inside.

    Arguments:

    - `low`, `high`: corners, (3,) [m].
    - `where`: what messages call this box.

    Raises `InputError` for corners that are not finite, and for a box that is inside out.
    """

    low: Float[np.ndarray, "3"]
    high: Float[np.ndarray, "3"]

    def __init__(self, low: ArrayLike, high: ArrayLike, *, where: str = "box") -> None:
        self.low = check_vector(low, where=where, quantity="lower corner [m]")
        self.high = check_vector(high, where=where, quantity="upper corner [m]")
        if (self.low > self.high).any():
            raise InputError(
                "box is inside out", where=where,
                value=f"{self.low.tolist()} to {self.high.tolist()}",
                limit="lower corner at most the upper corner in x, y and z",
                remedy="give [[smallest x, y, z], [largest x, y, z]] in metres",
            )  # fmt: skip

    def holds(
        self, points: Float[np.ndarray, "points 3"], slack: float
    ) -> Bool[np.ndarray, " points"]:
        """Which points [m] lie inside, or off it by `slack` [m] at the most along each axis."""
        inside = (points >= self.low - slack) & (points <= self.high + slack)
        return np.asarray(inside.all(1))
