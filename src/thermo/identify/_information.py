"""What readings say of the unknowns together: the Fisher information."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.fields import QUANTITIES
from thermo.inverse import SCALES, Sensitivity


def check_model_error(model_error: float) -> None:
    """Refuse errors of a simulation [K] that cannot be. Raises `InputError`."""
    if not (np.isfinite(model_error) and model_error >= 0):
        raise InputError(
            "an error of the simulation cannot be this", where="model_error", value=model_error,
            limit="a finite number, 0 or more [K]", remedy="leave it at 0.01 K",
        )  # fmt: skip


def information(at: Sensitivity, model_error: float) -> Float[np.ndarray, "unknowns unknowns"]:
    """J' C^-1 J of all runs, for unknowns log(phi) [1].

    C is the covariance of the readings: `noise`^2 for each by itself, and `model_error`^2 and
    `staying`^2 for an error that stays the same over all frames of a sample, so that

        J'C^-1 J = 1/noise^2 sum over samples (sum_t J_t'J_t - m s's),   s = sum_t J_t,

    with m = stays^2 / (noise^2 + frames stays^2), stays^2 = model_error^2 + staying^2. What the n
    samples of a frame have in common (`common`) adds n times its square to the variances of
    sqrt(n) times their mean, and nothing to those of what is left of J without that mean.

    Arguments: `at`: slopes of the temperatures [K]; `model_error` [K].

    Raises `InputError` where `model_error` cannot be.
    """
    check_model_error(model_error)
    total = np.zeros((len(at.names), len(at.names)))
    for run, slopes in at.slopes.items():
        total += _weighed(at, run, model_error, slopes, slopes)
    return total


def _weighed(
    at: Sensitivity,
    run: str,
    model_error: float,
    left: Float[np.ndarray, "frames samples lefts"],
    right: Float[np.ndarray, "frames samples rights"],
) -> Float[np.ndarray, "lefts rights"]:
    """L' C^-1 R of one run."""
    noise = at.noise[run] ** 2
    stays = model_error**2 + at.staying.get(run, 0.0) ** 2
    frame, lasting = at.common.get(run, (0.0, 0.0))
    if frame == 0.0:
        return _each_by_itself(left, right, noise, stays)
    count = left.shape[1]
    first, second = (part.mean(1, keepdims=True) for part in (left, right))
    apart = _each_by_itself(left - first, right - second, noise, stays)
    wide = noise + count * frame**2, stays + count * lasting**2
    return apart + count * _each_by_itself(first, second, *wide)


def _each_by_itself(
    left: Float[np.ndarray, "frames samples lefts"],
    right: Float[np.ndarray, "frames samples rights"],
    noise: float,
    stays: float,
) -> Float[np.ndarray, "lefts rights"]:
    """The same for samples that have nothing in common; variances [K2]."""
    share = stays / (noise + len(left) * stays)
    every = np.einsum("tsi,tsj->ij", left, right) - share * left.sum(0).T @ right.sum(0)
    return every / noise


def pulls(at: Sensitivity, model_error: float) -> Float[np.ndarray, "unknowns causes"]:
    """J' C^-1 d of each run that has a defect d, and of one deviation of the scale [1].

    C as in `information`, and arguments as there; times the covariance of log(phi) it is what the
    defect or the scale moves them by. The scale is that of all runs at once.
    """
    columns = _pulled(at, at.defect, model_error)
    if at.scale:
        columns += [at.scale_deviation * np.sum(_pulled(at, at.scale, model_error), axis=0)]
    return np.reshape(columns, (len(columns), len(at.names))).T


def _pulled(
    at: Sensitivity, causes: Mapping[str, Float[np.ndarray, "frames samples"]], model_error: float
) -> list[Float[np.ndarray, " unknowns"]]:
    return [
        _weighed(at, run, model_error, at.slopes[run], apart[..., None])[:, 0]
        for run, apart in causes.items()
    ]


def bounds_of(name: str) -> tuple[float, float]:
    """Least and largest value of a quantity [SI] or of a factor [1]."""
    found = QUANTITIES[name] if name in QUANTITIES else SCALES[name]
    return found.lower, found.upper


def numbered(names: tuple[str, ...]) -> tuple[str, ...]:
    """Names of which those that occur more than once are numbered from 0."""
    return tuple(
        name if names.count(name) == 1 else f"{name}[{names[:place].count(name)}]"
        for place, name in enumerate(names)
    )
