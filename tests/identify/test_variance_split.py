"""Parts of a variance: by hand, made-up parts found again without bias, refusals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.identify import split_variance


def test_a_table_worked_out_by_hand() -> None:
    found = split_variance(np.array([[1.0, 3.0], [5.0, 7.0]]))
    # Means 2 and 6; variances 2 and 2.
    assert found.within == 2.0 and found.across_raw == 8.0
    assert found.across == 7.0 and found.share() == pytest.approx(7 / 9)


@pytest.mark.parametrize(("within", "across"), [(1.0, 4.0), (1.0, 0.25), (2.0, 0.0)])
def test_made_up_parts_are_found_on_average(within: float, across: float) -> None:
    random, parts = np.random.default_rng(0), []
    for _ in range(4000):
        start = np.sqrt(across) * random.standard_normal((4, 1))
        found = split_variance(start + np.sqrt(within) * random.standard_normal((4, 4)))
        parts.append((found.within, found.across_raw - found.within / 4, found.across_raw))
    mean = np.mean(parts, axis=0)
    # Of four starts the variance is known to 80 %, of 4000 tables its mean to 1.3 %.
    assert mean[0] == pytest.approx(within, rel=0.05)
    assert mean[1] == pytest.approx(across, abs=0.05 * (across + within / 4))
    assert mean[2] == pytest.approx(across + within / 4, rel=0.05)


@given(seed=st.integers(0, 999), scale=st.floats(1e-9, 1e3), shift=st.floats(-10, 10))
def test_a_shift_does_not_count_and_a_scale_is_squared(
    seed: int, scale: float, shift: float
) -> None:
    values = np.random.default_rng(seed).standard_normal((3, 5))
    plain, other = split_variance(values), split_variance(scale * (values + shift))
    assert other.within == pytest.approx(scale**2 * plain.within, rel=1e-9)
    assert other.across == pytest.approx(scale**2 * plain.across, rel=1e-6, abs=1e-9 * scale**2)
    assert 0 <= plain.across <= plain.across_raw


def test_fits_that_all_agree_have_no_part() -> None:
    assert split_variance(np.ones((2, 2))).share() == 0.0


@pytest.mark.parametrize(
    "values", [np.ones((1, 4)), np.ones((4, 1)), np.array([[1.0, np.nan], [1.0, 2.0]])]
)
def test_what_cannot_be_split_is_refused(values: np.ndarray) -> None:
    with pytest.raises(InputError, match="cannot be split"):
        split_variance(values)
