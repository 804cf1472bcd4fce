"""How often the whole of the search's alarm would be false on the case at hand, by simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from jaxtyping import Float
from scipy.linalg import cho_solve
from scipy.stats import chi2

from thermo.discover._projection import Projection
from thermo.discover._scores import ScoreTable, normal_draws
from thermo.discover._softening import Block, in_shapes, shape_products


@final
@dataclass(frozen=True)
class Calibration:
    """What noise and all that is allowed for would do where nothing is missing.

    - `largest`: the largest score of each draw, increasing, (draws,) [1].
    - `by_score`, `by_shapes`, `either`: shares of the draws that raise an alarm [1].
    """

    largest: Float[np.ndarray, " draws"]
    by_score: float
    by_shapes: float
    either: float


def calibration(
    table: ScoreTable, free: Projection, runs: list[Block], *, shapes: float, seed: int = 1
) -> Calibration:
    """Alarms on residuals drawn as noise and what is allowed for make them.

    Each draw goes through the fit of the unknowns, linearised, and then through both gates: the
    largest score against the table's threshold, and the smooth shapes at the level `shapes` [1].
    Scores and shapes come of the same residual, so that what they share is counted once. As both
    are linear in it they are normal, and drawn by their covariance.
    """
    scores = table.unit.shape[1]
    drawn = normal_draws(_covariance(table.unit, free, runs), seed)
    sizes = table.largest(drawn[:, :scores])
    told = (drawn[:, scores:] ** 2).sum(1)
    by_score = sizes > table.threshold
    by_shapes = chi2.sf(told, drawn.shape[1] - scores) < shapes
    return Calibration(
        np.sort(sizes),
        float(by_score.mean()),
        float(by_shapes.mean()),
        float((by_score | by_shapes).mean()),
    )


def _covariance(
    unit: Float[np.ndarray, "values columns"], free: Projection, runs: list[Block]
) -> Float[np.ndarray, "told told"]:
    """Of the scores, and of the coefficients of smooth shapes, of what the fit leaves of noise [1].

    The signatures `unit` are what the fit leaves already.
    """
    of_scores, of_free = in_shapes(runs, unit), in_shapes(runs, free.columns)
    taken = of_free @ cho_solve(free.factor, of_free.T)
    return np.block([[unit.T @ unit, of_scores.T], [of_scores, shape_products(runs) - taken]])
