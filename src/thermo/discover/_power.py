"""How strong an effect has to be so that its score passes the threshold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, final

import numpy as np
from scipy.optimize import root_scalar
from scipy.stats import chi2, ncx2, norm

from thermo.discover._scores import Score, ScoreTable

SHARES: Final = (0.5, 0.8, 0.95)
"""Of cases in which an effect is found, of which its strength is told [1]."""

# No score is this many deviations above its threshold by chance [1].
_SURE: Final = 10.0


@final
@dataclass(frozen=True)
class Power:
    """What would have been found of a kind of effect, wherever it is.

    - `unit`: of strengths; `strengths`: which one is found in each of `SHARES`, None where no
      strength that there can be is.
    """

    unit: str
    strengths: Mapping[float, float | None]


def powers(table: ScoreTable) -> Mapping[str, Power]:
    """By kind, of its part that shows least.

    Source: Cox and Hinkley, Theoretical Statistics (1974), section 4.3, power functions.
    """
    found: dict[str, Power] = {}
    for score in table.scores:
        card = score.entry.card
        known = found.get(card.name)
        least: dict[float, float | None] = {}
        for share in SHARES:
            other = 0.0 if known is None else known.strengths[share]
            own = strength_found(score, table.threshold, share)
            seen = None if other is None else max(own, other)
            least[share] = None if seen is None or seen > card.high else seen
        found[card.name] = Power(card.unit, least)
    # Where one part could not be seen at all, no strength of that kind is sure to be found.
    blind: dict[float, float | None] = dict.fromkeys(SHARES)
    return found | {one.card.name: Power(one.card.unit, blind) for one in table.unseen}


def strength_found(score: Score, threshold: float, share: float) -> float:
    """The strength, in the card's unit, whose score passes the threshold [1] in a share of cases.

    The score's square is a non-central chi-square of as many degrees of freedom as the part has
    strengths; of a strength that cannot be negative the score has to be positive as well. Where the
    part has several, the others are such that it shows least.
    """
    count = len(score.entry.strengths)
    if count == 1 and score.entry.card.low >= 0:
        return score.sd * (threshold + float(norm.ppf(share)))
    return score.sd * _away(threshold, count, share)


@lru_cache
def _away(threshold: float, count: int, share: float) -> float:
    """Deviations [1] at which so many strengths together pass the threshold in a share of cases."""
    limit = float(chi2.isf(2 * norm.sf(threshold), count))

    def missing(away: float) -> float:
        return float(ncx2.sf(limit, count, away**2)) - share

    bracket = (1e-3, float(np.sqrt(limit)) + _SURE)
    return float(root_scalar(missing, bracket=bracket).root)
