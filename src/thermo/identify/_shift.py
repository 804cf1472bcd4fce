"""What a stated value that is wrong does to those that are fitted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.identify._information import information, numbered, pulls
from thermo.identify._spectrum import spectrum
from thermo.inverse import Sensitivity

SCALE: Final = "the surface's scale"
"""What shifts call the scale of the surface."""


@final
@dataclass(frozen=True)
class Shift:
    """By how much one unknown moves when a stated value is too large.

    - `name`: of the unknown; `held`: of what is stated, `doubt`: by how much log(held) is too
      large [1]; too small by as much moves the other way.
    - `relative`: change of log(name) that the fit makes to meet the readings all the same [1].
    - `deviations`: that change over the standard deviation of log(name) [1].
    """

    name: str
    held: str
    doubt: float
    relative: float
    deviations: float


def shifts(
    at: Sensitivity,
    doubt: Mapping[str, float],
    *,
    prior: Mapping[str, float] | None = None,
    model_error: float = 0.01,
) -> list[Shift]:
    """How far each stated value that is in doubt moves each unknown, the largest first.

    With J the slopes of the unknowns, g that of the stated value, both whitened, and Q the prior
    covariance of the unknowns, b = -(J'J + Q^-1)^-1 J'g doubt, to first order. The scale of the
    surface is in doubt by its own deviation, where `at` holds one.

    Arguments:

    - `at`: slopes of the unknowns and of the stated values alike [K].
    - `doubt`: by stated value, by how much its logarithm may be off [1]; what it does not name is
      an unknown.
    - `prior`: by unknown, standard deviation of log(phi) before the data [1]; by default that of
      an even spread over its bounds.
    - `model_error`: what the simulation itself may be wrong by [K].

    Raises `InputError` for a doubt about what `at` does not have, or that leaves no unknown.
    """
    kept = [place for place, name in enumerate(at.names) if name not in doubt]
    wrong = [name for name, size in doubt.items() if at.names.count(name) != 1 or size <= 0]
    if wrong or not kept:
        raise InputError(
            "this doubt cannot be", where=f"doubt.{wrong[0]}" if wrong else "doubt",
            value=doubt[wrong[0]] if wrong else ", ".join(doubt),
            limit=f"a number above 0 for single values of {', '.join(dict.fromkeys(at.names))}, "
            "and one of them an unknown",
            remedy="give by how much the logarithm may be off, 0.02 for 2 %",
        )  # fmt: skip
    found = spectrum(unknowns_of(at, doubt), prior=prior, model_error=model_error)
    covariance, deviation = found.covariance(), found.deviation()
    square, names = information(at, model_error), numbered(at.names)
    every = []
    pulled = {held: square[kept, at.names.index(held)] * size for held, size in doubt.items()}
    sizes = dict(doubt)
    if at.scale:
        alone = replace(unknowns_of(at, doubt), defect={})
        pulled[SCALE], sizes[SCALE] = pulls(alone, model_error)[:, 0], at.scale_deviation
    for held, pull in pulled.items():
        moved: Float[np.ndarray, " unknowns"] = -covariance @ pull
        every += [
            Shift(names[place], held, sizes[held], float(move), float(move / sd))
            for place, move, sd in zip(kept, moved, deviation, strict=True)
        ]
    return sorted(every, key=lambda one: -abs(one.deviations))


def unknowns_of(at: Sensitivity, stated: Mapping[str, object]) -> Sensitivity:
    """The slopes [K] without those of values that are stated."""
    kept = [place for place, name in enumerate(at.names) if name not in stated]
    return replace(
        at,
        names=tuple(at.names[place] for place in kept),
        slopes={run: slopes[..., kept] for run, slopes in at.slopes.items()},
        values=tuple(at.values[place] for place in kept) if at.values else (),
    )
