"""Samples that lie away from the surface are refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.observe import check_distance


def call(*distances: float):
    return lambda: check_distance(np.array(distances), diagonal=0.1, where="run.npz")


@pytest.mark.parametrize(
    ("distances", "value", "remedy"),
    [
        ((0.003, 0.003, 0.003), "median distance 0.003 m", "registration"),
        ((0.001, 0.001, 0.02), "sample 2", "stray"),
        ((1.0, 1.1, 1.2), "largest 1.2 m", "registration"),
        ((20.0, 30.0, 40.0), "median distance 30 m", "millimetres"),
        ((np.nan, 0.0, 0.0), "nan", "metres"),
    ],
)
def test_far_samples_are_refused(distances, value, remedy, refuses) -> None:
    refuses(
        call(*distances), where="run.npz: points", value=value, limit="2% and every one at most",
        remedy=remedy,
    )  # fmt: skip


@given(st.lists(st.floats(0, 0.3), min_size=1, max_size=9))
def test_exactly_the_two_limits_decide(distances: list[float]) -> None:
    close = np.median(distances) <= 0.02 * 0.1 and max(distances) <= 0.1 * 0.1
    if close:
        call(*distances)()
    else:
        with pytest.raises(InputError):
            call(*distances)()
