"""Which directions the data lead and which the prior: eigenvalues of the information."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.identify._combination import Combination, combinations
from thermo.identify._information import bounds_of, information, numbered
from thermo.inverse import Sensitivity

_ROUNDING: Final = 1e-12
"""Eigenvalues below this share of the largest are rounding [1]."""

_SLOPE_ERROR: Final = 3.0
"""Error of a slope over the tolerance of the solver that made it, both relative [1]."""


@final
@dataclass(frozen=True)
class Spectrum:
    """What data and prior say together of log(phi), as far as slopes at one point tell.

    - `names`: of the unknowns; several values of one quantity are numbered.
    - `prior`: standard deviation of log(phi) without the data, (unknowns,) [1].
    - `eigenvalues`: of the data's information in units of the prior's, largest first,
      (directions,) [1]. Above 1 the data lead, below 1 the prior.
    - `directions`: changes of log(phi), one prior standard deviation long each,
      (unknowns, directions) [1].
    - `hidden`: eigenvalue [1] up to which slopes of this accuracy show nothing.
    """

    names: tuple[str, ...]
    prior: Float[np.ndarray, " unknowns"]
    eigenvalues: Float[np.ndarray, " directions"]
    directions: Float[np.ndarray, "unknowns directions"]
    hidden: float

    def known(self) -> Float[np.ndarray, " directions"]:
        """Share of each direction's prior variance that the data take away [1]."""
        seen = np.where(self.eigenvalues > self.hidden, self.eigenvalues, 0.0)
        return seen / (1 + seen)

    def covariance(self) -> Float[np.ndarray, "unknowns unknowns"]:
        """Covariance of log(phi) after the data [1]."""
        return (self.directions * (1 - self.known())) @ self.directions.T

    def deviation(self) -> Float[np.ndarray, " unknowns"]:
        """Standard deviation of log(phi) after the data [1]."""
        return np.sqrt(np.diagonal(self.covariance()))

    def correlation(self) -> Float[np.ndarray, "unknowns unknowns"]:
        """Correlation of the errors that are left [1]."""
        deviation = self.deviation()
        return self.covariance() / np.outer(deviation, deviation)

    def informed(self) -> Float[np.ndarray, " unknowns"]:
        """Share of each unknown's prior variance that the data take away [1].

        The shares sum to that of the directions: where one direction is the prior's, they cannot
        all be 1.
        """
        return 1 - (self.deviation() / self.prior) ** 2

    def data_led(self) -> int:
        """Number of directions that the data lead [1]."""
        return int(np.sum(self.eigenvalues > max(1.0, self.hidden)))

    def undetermined(self) -> list[Combination]:
        """Changes of the unknowns that the data do not tell from none."""
        return combinations(self.names, self.directions[:, self.data_led() :])


def spectrum(
    at: Sensitivity, *, prior: Mapping[str, float] | None = None, model_error: float = 0.01
) -> Spectrum:
    """Eigenvalues and directions of Q^1/2 J' C^-1 J Q^1/2, with Q the prior covariance of log(phi).

    with C of independent noise and an error of the simulation that stays the same over all frames
    of a sample. What is found is the most that any fit can know; `expected_errors` is what a fit
    knows that weighs its readings alike.

    Arguments:

    - `at`: slopes of the temperatures [K].
    - `prior`: by quantity, standard deviation of log(phi) before the data [1]; by default that of
      an even spread over its bounds.
    - `model_error`: what the simulation itself may be wrong by [K].

    Raises `InputError` where a prior or `model_error` cannot be.

    Source: the eigenvalues of the data's Hessian in the metric of the prior, Bui-Thanh, Ghattas,
    Martin and Stadler, SIAM J. Sci. Comput. 35 (2013) A2494, section 4.
    """
    deviation = _prior(at.names, {} if prior is None else prior)
    scaled = np.outer(deviation, deviation) * information(at, model_error)
    size, way = np.linalg.eigh(scaled)
    size, way = np.maximum(size[::-1], 0.0), way[:, ::-1]
    accuracy = len(size) * (_ROUNDING + (_SLOPE_ERROR * at.accuracy) ** 2)
    return Spectrum(
        names=numbered(at.names),
        prior=deviation,
        eigenvalues=size,
        directions=deviation[:, None] * way,
        hidden=float(accuracy * size[0]),
    )


def _prior(names: tuple[str, ...], stated: Mapping[str, float]) -> Float[np.ndarray, " unknowns"]:
    wrong = [name for name in stated if name not in names]
    wrong += [name for name, value in stated.items() if not (np.isfinite(value) and value > 0)]
    if wrong:
        raise InputError(
            "this prior cannot be", where=f"prior.{wrong[0]}", value=stated[wrong[0]],
            limit=f"a finite number above 0 for one of {', '.join(dict.fromkeys(names))}",
            remedy="give the standard deviation of the logarithm, 0.1 for 10 %",
        )  # fmt: skip

    def even(name: str) -> float:
        lower, upper = bounds_of(name)
        return float(np.log(upper / lower) / np.sqrt(12))

    return np.array([stated.get(name) or even(name) for name in names])
