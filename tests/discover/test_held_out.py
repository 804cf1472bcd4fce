"""How much of a gap is closed on readings that were not fitted, and how sure that is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.discover._held_out import closed, closed_interval

FRAMES = 50.0


def squares(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    return np.stack([before, after, np.full(len(before), FRAMES)])


@given(st.floats(0.0, 1.0), st.integers(10, 60))
def test_where_samples_are_alike_the_share_is_sure(share: float, samples: int) -> None:
    made = squares(np.full(samples, 10 * FRAMES), np.full(samples, FRAMES * (10 - 9 * share)))
    assert float(closed(made.sum(1))) == pytest.approx(share, abs=1e-9)
    assert closed_interval(made, 0.0) == pytest.approx((share, share), abs=1e-9)


def test_of_many_drawn_bodies_the_interval_holds_the_true_share_as_often_as_it_says() -> None:
    random, inside = np.random.default_rng(0), 0
    for _ in range(300):
        gap = random.exponential(200.0, 80)
        rest = gap * random.uniform(0, 0.4, 80)
        ends = closed_interval(squares(FRAMES + gap, FRAMES + rest), 0.0)
        assert ends is not None
        inside += ends[0] <= 0.8 <= ends[1]
    # Of 300 at 95 % fewer than 270 come once in ten thousand.
    assert inside >= 270


def test_few_samples_tell_no_interval() -> None:
    assert closed_interval(squares(np.full(9, 500.0), np.full(9, 60.0)), 0.1) is None


@given(st.floats(0.01, 0.2))
def test_noise_that_is_not_well_known_widens_the_interval(doubt: float) -> None:
    # Of 10 units 9 are a gap, and a tenth of noise more leaves a tenth less of what is left.
    made = squares(np.full(80, 10 * FRAMES), np.full(80, 1.9 * FRAMES))
    ends = closed_interval(made, doubt)
    assert ends is not None
    low, high = (1 - (0.9 - 1.96 * way * doubt) / (9 - 1.96 * way * doubt) for way in (-1, 1))
    assert ends == pytest.approx((low, high), abs=0.03 * doubt)
