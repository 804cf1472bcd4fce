"""How well a fit will know its unknowns, from the Jacobian alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jaxtyping import Float

from thermo.identify._information import check_model_error
from thermo.inverse import Sensitivity

# Eigenvalues of the scaled information below this share of the largest are of directions that no
# run shows, and so is an unknown of which more than this share lies in them [1].
_BLIND: Final = 1e-12
_SHARE: Final = 1e-6


@final
@dataclass(frozen=True)
class ExpectedError:
    """How well one unknown will be known.

    - `name`: of the quantity; `relative`: standard deviation of log(phi) [1], infinite where the
      runs do not show it.
    - `response`: root mean square change of the readings when phi changes by a factor e, nothing
      else changing [K].
    """

    name: str
    relative: float
    response: float

    def informed(self, wanted: float) -> bool:
        """Whether a relative error [1] stays within `wanted` with a probability of 95 %."""
        return 1.96 * self.relative <= wanted


def expected_errors(at: Sensitivity, *, model_error: float = 0.01) -> list[ExpectedError]:
    """Errors of a least-squares fit whose readings weigh alike in a run.

    cov(log phi) = A^-1 B A^-1,  A = sum J'J / s^2,  B = sum J'CJ / s^4,  s^2 = noise^2 + model^2.

    C holds `noise`^2 for each reading by itself, and for what stays the same over all frames of a
    sample `model`^2, for an error of the simulation, and `staying`^2: such errors do not average
    out over time. What samples have in common (`common`) does not average out over them.

    Arguments:

    - `at`: slopes of the temperatures [K].
    - `model_error`: what the simulation itself may be wrong by [K].

    Raises `InputError` where `model_error` is negative or not finite.

    Source: White, Econometrica 48 (1980) 817, the covariance of a fit whose weights are not those
    of its errors.
    """
    check_model_error(model_error)
    count = len(at.names)
    information, spread, square = (
        np.zeros((count, count)),
        np.zeros((count, count)),
        np.zeros(count),
    )
    readings = 0
    for run, slopes in at.slopes.items():
        noise = at.noise[run]
        variance = noise**2 + model_error**2
        each = np.einsum("tsi,tsj->ij", slopes, slopes)
        over_time = slopes.sum(0)
        information += each / variance
        repeated = over_time.T @ over_time
        stays = model_error**2 + at.staying.get(run, 0.0) ** 2
        spread += (noise**2 * each + stays * repeated) / variance**2
        frame, lasting = at.common.get(run, (0.0, 0.0))
        alike = slopes.sum(1)
        once = alike.sum(0)
        spread += (frame**2 * alike.T @ alike + lasting**2 * np.outer(once, once)) / variance**2
        square += np.diagonal(each)
        readings += slopes.shape[0] * slopes.shape[1]
    deviation = _deviations(information, spread)
    response = np.sqrt(square / readings)
    return [
        ExpectedError(name, float(sd), float(kelvin))
        for name, sd, kelvin in zip(at.names, deviation, response, strict=True)
    ]


def _deviations(
    information: Float[np.ndarray, "unknowns unknowns"],
    spread: Float[np.ndarray, "unknowns unknowns"],
) -> Float[np.ndarray, " unknowns"]:
    """Square roots of the diagonal of A^-1 B A^-1; infinite where A does not say."""
    scale = np.sqrt(np.diagonal(information))
    scale = np.where(scale > 0, scale, 1.0)
    size, way = np.linalg.eigh(information / np.outer(scale, scale))
    known = size > _BLIND * max(float(size[-1]), 0.0)
    inverse = (way[:, known] / size[known]) @ way[:, known].T / np.outer(scale, scale)
    variance = np.diagonal(inverse @ spread @ inverse)
    hidden = (way[:, ~known] ** 2).sum(1) > _SHARE
    return np.where(hidden, np.inf, np.sqrt(np.maximum(variance, 0.0)))
