"""False alarms by simulation: as many as the thresholds are set for."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom, chi2, ks_2samp

from thermo.discover._calibration import Calibration, _covariance, calibration
from thermo.discover._candidate import Card
from thermo.discover._entries import Entry
from thermo.discover._projection import Projection, projection
from thermo.discover._scores import ScoreTable, score_table
from thermo.discover._softening import Block, omnibus

FRAMES, SAMPLES = 20, 15
VALUES = FRAMES * SAMPLES
FOUND = [
    Entry(0, 0, Card("both", "W", 1.0, -np.inf, np.inf, "", "", ""), np.array([0])),
    Entry(1, 0, Card("one_sided", "W", 1.0, 0.0, np.inf, "", "", ""), np.array([1])),
    Entry(2, 0, Card("joint", "K", 1.0, -9.0, 9.0, "", "", "", joint=True), np.array([2, 3, 4])),
]


def case(alpha: float) -> tuple[ScoreTable, Projection, list[Block]]:
    random = np.random.default_rng(3)
    free = projection(random.standard_normal((VALUES, 3)))
    signatures = 4 * random.standard_normal((VALUES, 5))
    along = np.linalg.qr(random.standard_normal((FRAMES, 4)))[0]
    across = np.linalg.qr(random.standard_normal((SAMPLES, 5)))[0]
    run = Block("lamp", slice(0, VALUES), (FRAMES, SAMPLES), along, across, 0.0, 1.05, VALUES)
    table = score_table(FOUND, signatures, np.zeros(VALUES), free, alpha=alpha)
    return table, free, [run]


def made(*, alpha: float, shapes: float) -> Calibration:
    return calibration(*case(alpha), shapes=shapes)


@pytest.mark.parametrize("alpha", [0.04, 0.2])
def test_scores_raise_as_many_alarms_as_their_threshold_is_set_for(alpha: float) -> None:
    found = made(alpha=alpha, shapes=0.01)
    count = len(found.largest)
    low, high = binom.ppf([1e-4, 1 - 1e-4], count, alpha) / count
    assert low - 0.01 < found.by_score < high + 0.01
    assert np.all(np.diff(found.largest) >= 0) and found.largest[0] > 0


def test_shapes_raise_as_many_as_their_level() -> None:
    found = made(alpha=0.04, shapes=0.1)
    # Three of some twenty degrees of freedom may go into what is free.
    assert 0.03 < found.by_shapes < 0.15
    assert max(found.by_score, found.by_shapes) <= found.either
    assert found.either <= found.by_score + found.by_shapes


def test_alarms_are_those_of_residuals_drawn_one_by_one() -> None:
    table, free, runs = case(0.1)
    found = calibration(table, free, runs, shapes=0.1)
    left = free.left(np.random.default_rng(6).standard_normal((VALUES, 3000)))
    sizes = table.largest(-(left.T @ table.unit))
    told = [omnibus(runs, one) for one in left.T]
    by_shapes = np.array([chi2.sf(sum_, count) for sum_, count, _ in told]) < 0.1
    by_score = sizes > table.threshold
    assert ks_2samp(found.largest, sizes).pvalue > 1e-4
    for share, drawn in [
        (found.by_score, by_score),
        (found.by_shapes, by_shapes),
        (found.either, by_score | by_shapes),
    ]:
        # Four deviations of the difference of two shares.
        apart = 4 * np.sqrt(share * (1 - share) * (1 / len(found.largest) + 1 / len(drawn)))
        assert abs(share - drawn.mean()) < apart


def test_scores_and_shapes_of_one_residual_go_together() -> None:
    table, free, runs = case(0.1)
    shapes = np.kron(runs[0].in_time, runs[0].in_space)
    told = np.concatenate([table.unit, free.left(shapes)], 1)
    np.testing.assert_allclose(_covariance(table.unit, free, runs), told.T @ told, atol=1e-12)
