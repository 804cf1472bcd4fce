"""Between which values unknowns are looked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError

Bounds = Sequence[Sequence[float]] | Float[np.ndarray, "bounded 2"]
"""A lower and an upper value [1] for each unknown."""


def checked_bounds(bounds: Any, unknowns: int) -> Float[np.ndarray, "unknowns 2"]:
    """Bounds [1] as an array (unknowns, 2); where none are given, none hold.

    Raises `InputError` where they are not numbers, not a pair for each unknown, or leave no room.
    """
    if bounds is None:
        return np.tile([-np.inf, np.inf], (unknowns, 1))
    try:
        pairs = np.asarray(bounds, float)
    except (TypeError, ValueError):
        pairs = np.empty(0)
    if pairs.shape != (unknowns, 2):
        raise InputError(
            "bounds are not those of the unknowns", where="bounds", value=repr(bounds)[:100],
            limit=f"a lower and an upper number for each of {unknowns} unknowns, in their order",
            remedy="give `LogModel.bounds`, or an array of the same shape; they are of logarithms",
        )  # fmt: skip
    if not np.all(pairs[:, 0] < pairs[:, 1]):
        first = int(np.flatnonzero(~(pairs[:, 0] < pairs[:, 1]))[0])
        raise InputError(
            "bounds leave no room", where=f"bounds[{first}]", value=pairs[first].tolist(),
            limit="the lower one first, and below the upper", remedy="give wider ones",
        )  # fmt: skip
    return pairs
