"""What could have been missed: the smallest strength that would have been found."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from thermo.discover._discover import _missed
from thermo.discover._entries import Entry
from thermo.discover._scores import Score, ScoreTable
from thermo.discover.candidates import HiddenSource, SensorLag, Void

THRESHOLD = 3.3


def score(kind: type[HiddenSource | SensorLag | Void], sd: float) -> Score:
    entry = Entry(0, 0, kind.card, np.array([0]))
    return Score(entry, 1.0, np.ones(1), sd, 0.9, 0.1, slice(0, 1))


def test_it_is_the_strength_found_in_four_of_five_cases_wherever_it_is() -> None:
    scores = [score(HiddenSource, 0.02), score(HiddenSource, 0.05), score(Void, 0.5)]
    unseen = [Entry(0, 0, SensorLag.card, np.array([0]))]
    found = _missed(ScoreTable(scores, unseen, THRESHOLD, np.eye(3), np.zeros((4, 3))))
    least, unit = found["hidden_source"]
    assert least == pytest.approx(0.05 * (THRESHOLD + norm.isf(0.2))) and unit == "W"
    # A share of 2 is more than all.
    assert found["void"] == (None, "1") and found["sensor_lag"] == (None, "s")
