"""Where fits from several first values end, and how far noise alone would move them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.stats import chi2

from thermo.identify._bounds import Bounds, checked_bounds
from thermo.identify._path import Model, Point, settle

CLOSE: Final = 0.1
"""Distance of two end points, in standard deviations [1], up to which they are one."""

LEVEL_WITH: Final = 0.01
"""Difference of chi squared [1] up to which two end points are one."""


@final
@dataclass(frozen=True)
class Basins:
    """Ends of fits from several first values, the best basin first.

    - `centres`: an end point of each, (basins, unknowns) [1]; `chi2`: there, (basins,) [1].
    - `of_start`: which basin each first value leads to, (starts,); -1 where the fit did not settle.
    - `optimiser`: variance over the first values, the noise held, (unknowns,) [1]; `noise`: over
      draws of the noise, the first value held; `linear`: what the slopes at the best end foretell
      for that. The first two are zero without draws.
    - `draws`: of the noise [1].
    """

    centres: Float[np.ndarray, "basins unknowns"]
    chi2: Float[np.ndarray, " basins"]
    of_start: Int[np.ndarray, " starts"]
    optimiser: Float[np.ndarray, " unknowns"]
    noise: Float[np.ndarray, " unknowns"]
    linear: Float[np.ndarray, " unknowns"]
    draws: int

    def shares(self) -> Float[np.ndarray, " basins"]:
        """Share of the first values that lead to each basin [1]."""
        return np.array([np.mean(self.of_start == one) for one in range(len(self.centres))])

    def optimiser_share(self) -> Float[np.ndarray, " unknowns"]:
        """Part of the whole variance that is the optimiser's [1]."""
        whole = self.optimiser + self.noise
        return np.divide(self.optimiser, whole, out=np.zeros_like(whole), where=whole > 0)

    def noise_as_foretold(self) -> Bool[np.ndarray, " unknowns"]:
        """Whether the variance over draws lies within the 99 % limits about the linear one."""
        free = max(self.draws - 1, 1)
        low, high = chi2.ppf([0.005, 0.995], free) / free
        told = (self.linear > 0) & np.isfinite(self.linear)
        ratio = np.divide(self.noise, self.linear, out=np.ones_like(self.noise), where=told)
        return (self.draws < 2) | ((ratio >= low) & (ratio <= high))


def basins(
    model: Model,
    starts: Float[np.ndarray, "starts unknowns"],
    *,
    bounds: Bounds | None = None,
    draws: int = 0,
    seed: int = 0,
) -> Basins:
    """Fit from each first value, and again with each draw of the noise.

    Arguments:

    - `model`: whitened residual, priors included, and its Jacobian, at unknowns [1].
    - `starts`: first values (starts, unknowns) [1]; `bounds`: of the unknowns, none by default.
    - `draws`: of the noise [1], standard normal deviates added to the residual; `seed`: of these.

    End points are one where they lie within 0.1 standard deviations of each other, in the metric
    of the information there, and within 0.01 in chi squared.

    Raises `InputError` for bounds that are not a pair for each unknown or leave no room.

    Source: Var = E_noise Var_start + Var_noise E_start, the law of total variance.
    """
    starts = np.atleast_2d(np.asarray(starts, float))
    limits = checked_bounds(bounds, starts.shape[1])
    ends = [settle(model, start, limits) for start in starts]
    order, of_start = _merged(ends)
    best = ends[order[0]]
    random = np.random.default_rng(seed)
    moved = []
    for _ in range(draws):
        error = random.standard_normal(best.residual.shape)
        other = _with(model, error)
        moved.append([settle(other, end.unknowns, limits).unknowns for end in ends])
    # (draws, starts, unknowns); each fit begins where the one without that noise ended.
    every = np.array(moved).reshape(draws, len(starts), -1) if draws else np.zeros((1, 1, 1))
    return Basins(
        centres=np.array([ends[number].unknowns for number in order]),
        chi2=np.array([ends[number].chi2 for number in order]),
        of_start=of_start,
        optimiser=np.broadcast_to(every.var(1).mean(0), starts.shape[1:]).copy(),
        noise=np.broadcast_to(_spread(every.mean(1)), starts.shape[1:]).copy(),
        linear=_linear(best),
        draws=draws,
    )


def _with(model: Model, error: Float[np.ndarray, " values"]) -> Model:
    def drawn(
        unknowns: Float[np.ndarray, " unknowns"],
    ) -> tuple[Float[np.ndarray, " values"], Float[np.ndarray, "values unknowns"]]:
        residual, matrix = model(unknowns)
        return residual + error, matrix

    return drawn


def _spread(means: np.ndarray) -> np.ndarray:
    return means.var(0, ddof=1) if len(means) > 1 else np.zeros(means.shape[1])


def _linear(best: Point) -> Float[np.ndarray, " unknowns"]:
    """Variance of each unknown [1] by the slopes; infinite where they do not show it."""
    square = best.jacobian.T @ best.jacobian
    length = np.sqrt(np.diagonal(square))
    seen = length > 0
    found = np.full(len(length), np.inf)
    scaled = square[np.ix_(seen, seen)] / np.outer(length[seen], length[seen])
    found[seen] = np.diagonal(np.linalg.pinv(scaled, hermitian=True)) / length[seen] ** 2
    return found


def _merged(ends: list[Point]) -> tuple[list[int], Int[np.ndarray, " starts"]]:
    """Numbers of the end points that stand for a basin, best first, and the basin of each."""
    basin = np.full(len(ends), -1)
    heads: list[int] = []
    for number in sorted(range(len(ends)), key=lambda one: ends[one].chi2):
        mine = ends[number]
        if not mine.settled():
            continue
        for place, head in enumerate(heads):
            other = ends[head]
            apart = other.jacobian @ (mine.unknowns - other.unknowns)
            if mine.chi2 - other.chi2 < LEVEL_WITH and np.linalg.norm(apart) < CLOSE:
                basin[number] = place
                break
        else:
            basin[number] = len(heads)
            heads.append(number)
    # Where none settled, the lowest end stands for what there is.
    return heads or [min(range(len(ends)), key=lambda one: ends[one].chi2)], basin
