"""How often the whole of the search's alarm would be false on the case at hand, by simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from jaxtyping import Float
from scipy.stats import chi2

from thermo.discover._projection import Projection
from thermo.discover._scores import ScoreTable
from thermo.discover._softening import Block, omnibus

_DRAWS: Final = 1000
# Draws that are held at a time [1].
_AT_ONCE: Final = 50


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
    Scores and shapes come of the same residual, so that what they share is counted once.
    """
    random, count = np.random.default_rng(seed), len(free.columns)
    largest, loud = [], []
    for begin in range(0, _DRAWS, _AT_ONCE):
        drawn = random.standard_normal((count, min(_AT_ONCE, _DRAWS - begin)))
        left = free.left(drawn)
        largest.append(table.largest(-(left.T @ table.unit)))
        loud += [_by_shapes(runs, one) < shapes for one in left.T]
    sizes, by_shapes = np.concatenate(largest), np.array(loud)
    by_score = sizes > table.threshold
    return Calibration(
        np.sort(sizes),
        float(by_score.mean()),
        float(by_shapes.mean()),
        float((by_score | by_shapes).mean()),
    )


def _by_shapes(runs: list[Block], residual: Float[np.ndarray, " values"]) -> float:
    told, count, _ = omnibus(runs, residual)
    return float(chi2.sf(told, count))
