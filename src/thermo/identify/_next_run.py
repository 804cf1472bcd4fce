"""Which run to make next: what each one that could be made would tell beside those that are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.identify._information import numbered
from thermo.identify._spectrum import spectrum
from thermo.inverse import Sensitivity


@final
@dataclass(frozen=True)
class NextRun:
    """What one more run would leave open.

    - `name`: of the candidate.
    - `gain`: by which it raises the information, half the logarithm of the ratio of determinants
      of the covariances before and after [1]; the D-optimal run has the most.
    - `mean`: root mean square over the unknowns of the standard deviation of log(phi) after it [1];
      the A-optimal run has the least.
    - `weakest`: standard deviation [1] after it along the direction that is known least now.
    - `pair`: of two unknowns to be told apart, the largest standard deviation of any combination
      of both after it [1]; None where none were named.
    - `before`: what `pair`, or without one `weakest`, is without that run [1].
    """

    name: str
    gain: float
    mean: float
    weakest: float
    pair: float | None
    before: float


def next_runs(
    now: Sensitivity,
    candidates: Mapping[str, Sensitivity],
    *,
    split: tuple[str, str] | None = None,
    prior: Mapping[str, float] | None = None,
    model_error: float = 0.01,
) -> list[NextRun]:
    """Candidates in order of what they tell: of the weakest direction, or of a pair.

    Arguments:

    - `now`: slopes of the runs that there are [K]; `candidates`: by name those of runs that could
      be made, with the same unknowns at the same values. Their noise is what the camera has.
    - `split`: two unknowns to be told apart, which then decide the order.
    - `prior`: by unknown, standard deviation of log(phi) before the data [1]; by default that of
      an even spread over its bounds.
    - `model_error`: what the simulation itself may be wrong by [K].

    Raises `InputError` for candidates with other unknowns and for a pair that is not among them.

    Source: Pukelsheim, Optimal Design of Experiments (2006), chapter 6; local at the values given.
    """
    names = numbered(now.names)
    pair = None if split is None else _numbers(names, split)
    before = spectrum(now, prior=prior, model_error=model_error)
    covariance = before.covariance()
    # In units of the prior, so that no direction is weak for its unit alone.
    _, ways = np.linalg.eigh(covariance / np.outer(before.prior, before.prior))
    weak = before.prior * ways[:, -1]
    weak = weak / np.linalg.norm(weak)
    open_now = _along(covariance, weak) if pair is None else _largest(covariance, pair)
    found = []
    for name, more in candidates.items():
        _check(name, now, more)
        after = spectrum(_both(now, more, name), prior=prior, model_error=model_error).covariance()
        found.append(
            NextRun(
                name=name,
                gain=0.5 * (_log_det(covariance) - _log_det(after)),
                mean=float(np.sqrt(np.mean(np.diagonal(after)))),
                weakest=_along(after, weak),
                pair=None if pair is None else _largest(after, pair),
                before=open_now,
            )
        )
    return sorted(found, key=lambda one: one.weakest if one.pair is None else one.pair)


def _along(covariance: np.ndarray, way: Float[np.ndarray, " unknowns"]) -> float:
    return float(np.sqrt(way @ covariance @ way))


def _log_det(covariance: np.ndarray) -> float:
    return float(np.linalg.slogdet(covariance)[1])


def _largest(covariance: np.ndarray, pair: list[int]) -> float:
    return float(np.sqrt(np.linalg.eigvalsh(covariance[np.ix_(pair, pair)])[-1]))


def _both(now: Sensitivity, more: Sensitivity, name: str) -> Sensitivity:
    """All runs together; those of the candidate get names of their own."""

    def added(one: Mapping[str, object], other: Mapping[str, object]) -> dict:
        return {**one, **{f"{name}: {run}": value for run, value in other.items()}}

    return Sensitivity(
        names=now.names,
        slopes=added(now.slopes, more.slopes),
        noise=added(now.noise, more.noise),
        accuracy=max(now.accuracy, more.accuracy),
        staying=added(now.staying, more.staying),
        common=added(now.common, more.common),
        values=now.values,
    )


def _numbers(names: tuple[str, ...], split: tuple[str, str]) -> list[int]:
    wrong = [name for name in split if name not in names]
    if wrong or split[0] == split[1]:
        raise InputError(
            "these two cannot be told apart", where="split", value=", ".join(split),
            limit=f"two of {', '.join(names)}", remedy="name two unknowns",
        )  # fmt: skip
    return [names.index(name) for name in split]


def _check(name: str, now: Sensitivity, more: Sensitivity) -> None:
    if more.names != now.names or not np.allclose(more.values, now.values, rtol=1e-6):
        raise InputError(
            "this candidate was looked at with other unknowns, or at other values",
            where=f"candidates.{name}", value=", ".join(more.names), limit=", ".join(now.names),
            remedy="ask `sensitivity` with the same `unknown`, `scales` and `initial`",
        )  # fmt: skip
