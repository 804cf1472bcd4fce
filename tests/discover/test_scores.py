"""Scores of made-up signatures: what chance alone reaches, and what a planted effect shows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.stats import binom, chi2, norm

from thermo.discover._candidate import Card
from thermo.discover._entries import Entry
from thermo.discover._projection import Projection, projection
from thermo.discover._scores import ScoreTable, credible, score_table

VALUES, FREE = 80, 3
ALPHA, DRAWS, FEWER = 0.05, 400, 150


def card(name: str, *, low: float = -np.inf, typical: float = 2.0, joint: bool = False) -> Card:
    return Card(name, "W", typical, low, np.inf, "", "", "", joint=joint)


def entry(kind: int, of: Card, *strengths: int, part: int = 0) -> Entry:
    return Entry(kind, part, of, np.array(strengths))


# One on both sides, one of which more is alike, one on one side, one of three strengths, places.
FOUND = [
    entry(0, card("both"), 0),
    entry(1, card("alike", typical=0.5), 1),
    entry(2, card("one_sided", low=0.0), 2),
    entry(3, card("joint", joint=True, typical=3.0), 3, 4, 5),
    *(entry(4, card("place", low=0.0), 6 + part, part=part) for part in range(4)),
]
COLUMNS = 10


@dataclass
class Made:
    """Slopes by what is free, and signatures by typical strengths."""

    free: np.ndarray
    signatures: np.ndarray

    def nuisances(self) -> Projection:
        return projection(self.free)

    def noise(self, seed: int) -> np.ndarray:
        """Noise of variance one, and what is free by far off."""
        make = np.random.default_rng(seed)
        return make.normal(size=VALUES) + self.free @ make.normal(0, 50, FREE)

    def table(self, residual: np.ndarray, alpha: float = ALPHA) -> ScoreTable:
        return score_table(FOUND, self.signatures, residual, self.nuisances(), alpha=alpha)


@pytest.fixture(scope="module")
def made() -> Made:
    make = np.random.default_rng(7)
    common = make.normal(size=(VALUES, 1))
    signatures = 0.8 * make.normal(size=(VALUES, COLUMNS)) + common * make.uniform(0, 1, COLUMNS)
    signatures[:, 1] = signatures[:, 0] + 0.2 * make.normal(size=VALUES)
    free = make.normal(size=(VALUES, FREE)) + 0.5 * common
    return Made(free, signatures)


@pytest.mark.parametrize("alpha", [0.05, 0.2])
def test_chance_alone_passes_the_threshold_as_often_as_it_is_to(made: Made, alpha: float) -> None:
    passed = 0
    for seed in range(DRAWS):
        table = made.table(made.noise(seed), alpha)
        assert len(table.scores) == len(FOUND) and not table.unseen
        passed += any(credible(one, table.threshold) for one in table.scores)
    # The threshold itself is drawn, and wrong by a tenth of its chance at the most.
    assert binom.ppf(0.002, DRAWS, 0.9 * alpha) <= passed <= binom.ppf(0.998, DRAWS, 1.1 * alpha)


def test_the_threshold_lies_between_those_of_one_score_and_of_independent_ones(made: Made) -> None:
    table = made.table(made.noise(0))
    assert norm.isf(ALPHA) < table.threshold < norm.isf(ALPHA / (2 * len(FOUND)))
    assert table.threshold < made.table(made.noise(0), 0.01).threshold
    assert table.threshold == made.table(made.noise(1)).threshold, "data do not enter"


@pytest.mark.parametrize("alpha", [0.05, 0.01])
@pytest.mark.parametrize(
    ("count", "low", "alike", "wanted"),
    [
        # Of one score, on both sides and on one.
        (1, -np.inf, False, lambda alpha: norm.isf(alpha / 2)),
        (1, 0.0, False, norm.isf),
        # Of several that are all the same, and of several that have nothing in common.
        (8, -np.inf, True, lambda alpha: norm.isf(alpha / 2)),
        (8, -np.inf, False, lambda alpha: norm.isf((1 - (1 - alpha) ** (1 / 8)) / 2)),
        (8, 0.0, False, lambda alpha: norm.isf(1 - (1 - alpha) ** (1 / 8))),
    ],
    ids=["both_sides", "one_side", "alike", "apart", "apart_one_side"],
)
def test_known_thresholds(
    alpha: float, count: int, low: float, alike: bool, wanted: Callable[[float], float]
) -> None:
    signatures = 3 * np.eye(VALUES)[:, [0] * count if alike else range(count)]
    found = [entry(number, card("some", low=low), number) for number in range(count)]
    none = projection(np.zeros((VALUES, 0)))
    table = score_table(found, signatures, np.zeros(VALUES), none, alpha=alpha)
    # Drawn 4000 times: the chance is right to a tenth of 5 %, and to a fifth of 1 %.
    assert table.threshold == pytest.approx(wanted(alpha), abs=0.1)


def test_the_threshold_of_a_history_is_that_of_one_score(made: Made) -> None:
    signatures = made.signatures[:, 3:6]
    found = [entry(0, FOUND[3].card, 0, 1, 2)]
    table = score_table(found, signatures, made.noise(0), made.nuisances(), alpha=ALPHA)
    assert table.threshold == pytest.approx(norm.isf(ALPHA / 2), abs=0.1)


def test_scores_of_noise_are_normal(made: Made) -> None:
    found = np.array(
        [[one.z for one in made.table(made.noise(seed)).scores] for seed in range(DRAWS)]
    )
    for each in found.T:
        told = float((each**2).sum())
        # Also of the one whose strengths are joint: it is a normal equivalent.
        assert chi2.ppf(1e-4, DRAWS) < told < chi2.ppf(1 - 1e-4, DRAWS)
    # Of the first two the signatures are alike, and so are the scores.
    alike = made.table(made.noise(0)).alike
    seen = float(np.corrcoef(found.T)[0, 1])
    assert alike[0, 1] > 0.8 and seen == pytest.approx(alike[0, 1], abs=0.1)
    np.testing.assert_allclose(np.diag(alike), 1.0)


@pytest.mark.parametrize(("number", "strength"), [(0, 5.0), (1, -3.0), (2, 1.0), (7, 4.0)])
def test_a_planted_effect_is_predicted_as_it_is(made: Made, number: int, strength: float) -> None:
    one = FOUND[number]
    slope = made.signatures[:, one.strengths[0]] / one.card.typical
    # Simulation less readings: the simulation lacks what is planted.
    lacking = -strength * slope
    exact = made.table(lacking).scores[number]
    assert exact.strength == pytest.approx([strength], rel=1e-8)
    assert exact.z == pytest.approx(strength / exact.sd, rel=1e-8)
    assert exact.entry is one and 0 < exact.visible < 1
    off = [
        (made.table(lacking + made.noise(seed)).scores[number].strength[0] - strength) / exact.sd
        for seed in range(FEWER)
    ]
    assert abs(np.mean(off)) < 4 / np.sqrt(FEWER)
    assert chi2.ppf(1e-4, FEWER) < float(np.sum(np.square(off))) < chi2.ppf(1 - 1e-4, FEWER)


def test_a_planted_history_is_predicted_as_it_is(made: Made) -> None:
    one, strengths = FOUND[3], np.array([2.0, -4.0, 7.0])
    lacking = -made.signatures[:, one.strengths] @ strengths / one.card.typical
    exact = made.table(lacking).scores[3]
    np.testing.assert_allclose(exact.strength, strengths, rtol=1e-8)
    assert exact.z > 5
    assert made.table(-lacking).scores[3].z == pytest.approx(-exact.z)
    off = [
        (made.table(lacking + made.noise(seed)).scores[3].strength[-1] - 7.0) / exact.sd
        for seed in range(FEWER)
    ]
    assert chi2.ppf(1e-4, FEWER) < float(np.sum(np.square(off))) < chi2.ppf(1 - 1e-4, FEWER)


def test_the_planted_effect_has_the_largest_score(made: Made) -> None:
    for number in (2, 5, 6):
        lacking = -8.0 * made.signatures[:, FOUND[number].strengths[0]]
        table = made.table(lacking + made.noise(number))
        best = max(table.scores, key=lambda one: abs(one.z))
        assert best.entry is FOUND[number] and credible(best, table.threshold)


def test_a_strength_on_the_wrong_side_is_not_credible(made: Made) -> None:
    for number, possible in [(0, True), (2, False)]:
        lacking = 8.0 * made.signatures[:, FOUND[number].strengths[0]]
        table = made.table(lacking)
        score = table.scores[number]
        assert score.z < -table.threshold and score.strength[0] < 0
        assert credible(score, table.threshold) is possible


@pytest.mark.parametrize("number", [0, 2, 3])
def test_what_the_unknowns_swallow_is_unseen(made: Made, number: int) -> None:
    signatures = made.signatures.copy()
    part = FOUND[number].strengths
    mixed = np.random.default_rng(1).normal(size=(FREE, len(part)))
    signatures[:, part] = made.free @ mixed
    table = score_table(FOUND, signatures, made.noise(0), made.nuisances(), alpha=ALPHA)
    assert table.unseen == [FOUND[number]]
    assert [one.entry for one in table.scores] == [one for one in FOUND if one is not FOUND[number]]
    # The others are scored as they were.
    before = made.table(made.noise(0))
    for one in table.scores:
        (same,) = (other for other in before.scores if other.entry is one.entry)
        assert one.z == pytest.approx(same.z)


def test_what_would_not_show_at_a_large_strength_is_unseen(made: Made) -> None:
    signatures = made.signatures.copy()
    left = made.nuisances().left(signatures[:, 0])
    size = float(np.sqrt(signatures[:, 0] @ left))
    for scale, unseen in [(0.99 / size, True), (1.01 / size, False)]:
        signatures[:, 0] = scale * made.signatures[:, 0]
        table = score_table(FOUND, signatures, made.noise(0), made.nuisances(), alpha=ALPHA)
        assert (FOUND[0] in table.unseen) is unseen


def test_visible_is_what_the_unknowns_leave_of_a_signature(made: Made) -> None:
    column = made.signatures[:, 0]
    left = made.nuisances().left(column)
    wanted = np.sqrt(column @ left) / np.linalg.norm(column)
    assert made.table(made.noise(0)).scores[0].visible == pytest.approx(wanted)


def test_where_nothing_can_be_seen_there_is_a_threshold_all_the_same(made: Made) -> None:
    none = np.zeros((VALUES, COLUMNS))
    table = score_table(FOUND, none, made.noise(0), made.nuisances(), alpha=ALPHA)
    assert not table.scores and table.unseen == FOUND
    assert table.threshold == pytest.approx(1.96, abs=1e-3)


@pytest.mark.filterwarnings("ignore:invalid value")
def test_a_history_of_which_one_strength_shows_nothing_is_scored(made: Made) -> None:
    signatures = made.signatures.copy()
    signatures[:, 4] = 0.0
    table = score_table(FOUND, signatures, made.noise(0), made.nuisances(), alpha=ALPHA)
    assert np.isfinite(table.threshold) and np.all(np.isfinite(table.alike))
