"""False alarms by simulation: as many as the thresholds are set for."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom

from thermo.discover._calibration import Calibration, calibration
from thermo.discover._candidate import Card
from thermo.discover._entries import Entry
from thermo.discover._projection import projection
from thermo.discover._scores import score_table
from thermo.discover._softening import Block

FRAMES, SAMPLES = 20, 15
VALUES = FRAMES * SAMPLES
FOUND = [
    Entry(0, 0, Card("both", "W", 1.0, -np.inf, np.inf, "", "", ""), np.array([0])),
    Entry(1, 0, Card("one_sided", "W", 1.0, 0.0, np.inf, "", "", ""), np.array([1])),
    Entry(2, 0, Card("joint", "K", 1.0, -9.0, 9.0, "", "", "", joint=True), np.array([2, 3, 4])),
]


def made(*, alpha: float, shapes: float) -> Calibration:
    random = np.random.default_rng(3)
    free = projection(random.standard_normal((VALUES, 3)))
    signatures = 4 * random.standard_normal((VALUES, 5))
    along = np.linalg.qr(random.standard_normal((FRAMES, 4)))[0]
    across = np.linalg.qr(random.standard_normal((SAMPLES, 5)))[0]
    run = Block("lamp", slice(0, VALUES), (FRAMES, SAMPLES), along, across, 0.0, 1.05, VALUES)
    table = score_table(FOUND, signatures, np.zeros(VALUES), free, alpha=alpha)
    return calibration(table, free, [run], shapes=shapes)


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
