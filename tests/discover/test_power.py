"""What could have been missed: the strengths that would have been found in a share of cases."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.stats import binom, norm

from thermo.discover import SHARES
from thermo.discover._candidate import Card
from thermo.discover._entries import Entry
from thermo.discover._power import powers, strength_found
from thermo.discover._projection import projection
from thermo.discover._scores import Score, ScoreTable, credible, score_table
from thermo.discover.candidates import HiddenSource, SensorLag, Void

THRESHOLD = 3.3
VALUES, DRAWS = 60, 500
MADE = np.random.default_rng(5).normal(size=(VALUES, 5))


def score(kind: type[HiddenSource | SensorLag | Void], sd: float) -> Score:
    entry = Entry(0, 0, kind.card, np.array([0]))
    return Score(entry, 1.0, np.ones(1), sd, 0.9, 0.1, slice(0, 1))


def test_it_is_the_strength_found_wherever_it_is() -> None:
    scores = [score(HiddenSource, 0.02), score(HiddenSource, 0.05), score(Void, 0.3)]
    unseen = [Entry(0, 0, SensorLag.card, np.array([0]))]
    found = powers(ScoreTable(scores, unseen, THRESHOLD, np.eye(3), np.zeros((4, 3))))
    assert found["hidden_source"].unit == "W" and tuple(found["void"].strengths) == SHARES
    for share in SHARES:
        least = found["hidden_source"].strengths[share]
        assert least == pytest.approx(0.05 * (THRESHOLD + norm.ppf(share)), rel=1e-3)
    # A share of more than all cannot be.
    assert found["void"].strengths == {0.5: pytest.approx(0.99), 0.8: None, 0.95: None}
    assert found["sensor_lag"].unit == "s" and set(found["sensor_lag"].strengths.values()) == {None}


def test_what_shows_least_decides_and_what_cannot_be_seen_stays_unseen() -> None:
    for order in ([0.3, 0.4], [0.4, 0.3]):
        table = ScoreTable([score(Void, sd) for sd in order], [], THRESHOLD, np.eye(2), np.eye(2))
        assert powers(table)["void"].strengths == dict.fromkeys(SHARES)


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize(
    ("low", "count", "threshold"),
    [(0.0, 1, 2.5), (-np.inf, 1, 1.5), (-np.inf, 1, 3.4), (-np.inf, 3, 2.5)],
    ids=["one_side", "both_sides", "both_sides_high", "three_strengths"],
)
def test_so_many_of_simulated_cases_are_found(
    low: float, count: int, threshold: float, share: float
) -> None:
    """Scores of a planted effect in noise, beside two unknowns, pass as often as foretold."""
    card = Card("some", "W", 2.0, low, np.inf, "", "", "", joint=count > 1)
    signatures, free = MADE[:, :count], projection(MADE[:, 3:])
    found = [Entry(0, 0, card, np.arange(count))]

    def scored(residual: np.ndarray) -> Score:
        return score_table(found, signatures, residual, free, alpha=0.05).scores[0]

    strength = strength_found(scored(np.zeros(VALUES)), threshold, share)
    # Of several the others are as shows least beside this one.
    inverse = np.linalg.inv(signatures.T @ free.left(signatures))
    way = inverse[:, -1] / inverse[-1, -1] * strength / card.typical
    noise = np.random.default_rng(11).normal(size=(DRAWS, VALUES))
    passed = sum(credible(scored(one - signatures @ way), threshold) for one in noise)
    assert binom.ppf(1e-3, DRAWS, share) <= passed <= binom.ppf(1 - 1e-3, DRAWS, share)


def test_a_weaker_effect_is_found_less_often() -> None:
    one: Any = score(SensorLag, 0.1)
    least = [strength_found(one, THRESHOLD, share) for share in SHARES]
    assert least == sorted(least)
