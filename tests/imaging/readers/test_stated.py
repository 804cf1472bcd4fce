"""What is stated about a file, and the times that follow."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging.readers import Stated
from thermo.imaging.readers._times import times_of


@pytest.mark.parametrize(
    ("wrong", "part"),
    [
        ({"rate": 0.0}, "above 0"),
        ({"rate": "fast"}, "not a number"),
        ({"unit": "F"}, "K, C, counts"),
        ({"scale": -0.01}, "out of range"),
        ({"rate": 30.0, "times": [0.0, 1.0]}, "times and rate"),
        ({"start": 1.0, "times": [0.0, 1.0]}, "times and start"),
        ({"unit": "counts", "scale": 0.01}, "exclude each other"),
        ({"times": [0.0, 1.0, 0.5]}, "time does not increase"),
    ],
)
def test_statements_are_checked(wrong: dict, part: str) -> None:
    with pytest.raises(InputError, match="settings of the frames") as caught:
        Stated(**wrong)
    assert part in str(caught.value)


@given(st.floats(0.1, 1e3), st.integers(2, 20), st.floats(-50.0, 50.0))
def test_a_rate_makes_even_times_from_the_start(rate: float, count: int, start: float) -> None:
    time = times_of(count, Stated(rate=rate, start=start), stamps=None, where="x")
    assert time[0] == start
    np.testing.assert_allclose(time[-1] - time[0], (count - 1) / rate, atol=1e-10)


def test_stamps_go_before_a_rate_and_stated_times_before_stamps() -> None:
    stamps = np.array([-1.0, 0.0, 2.0])
    np.testing.assert_array_equal(times_of(3, Stated(rate=9.0), stamps=stamps, where="x"), stamps)
    stated = Stated(times=[5.0, 6.0, 7.0])
    np.testing.assert_array_equal(times_of(3, stated, stamps=stamps, where="x"), [5.0, 6.0, 7.0])


def test_stamps_are_shifted_to_a_stated_start_and_a_calendars_to_zero() -> None:
    stamps = np.array([-1.0, 0.0, 2.0])
    moved = times_of(3, Stated(start=4.0), stamps=stamps, where="x")
    np.testing.assert_array_equal(moved, [4.0, 5.0, 7.0])
    dates = 1.7e9 + stamps
    np.testing.assert_array_equal(times_of(3, Stated(), stamps=dates, where="x"), [0.0, 1.0, 3.0])


def test_one_frame_needs_no_time_and_two_do() -> None:
    assert times_of(1, Stated(), stamps=None, where="x") == [0.0]
    assert times_of(1, Stated(start=-3.0), stamps=None, where="x") == [-3.0]
    with pytest.raises(InputError, match="nothing tells the times") as caught:
        times_of(2, Stated(), stamps=None, where="film.tif")
    assert "film.tif" in str(caught.value) and "recording.rate" in str(caught.value)
