"""Bounds in any form that numbers come in, and a clear word for all else."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.identify._bounds import checked_bounds


@pytest.mark.parametrize("given", [[[0, 1], [-2, 2]], np.array([[0.0, 1.0], [-2.0, 2.0]])])
def test_a_pair_for_each_unknown_is_taken(given: Any) -> None:
    np.testing.assert_array_equal(checked_bounds(given, 2), [[0.0, 1.0], [-2.0, 2.0]])


def test_where_none_are_given_none_hold() -> None:
    np.testing.assert_array_equal(checked_bounds(None, 3), [[-np.inf, np.inf]] * 3)


@pytest.mark.parametrize(
    "odd", [[0.0, 1.0], [[0.0, 1.0]], [[0.0], [1.0, 2.0]], {"conductivity": (0.1, 1.0)}, "wide"]
)
def test_what_is_no_pair_for_each_unknown_is_refused(odd: Any) -> None:
    with pytest.raises(InputError) as caught:
        checked_bounds(odd, 2)
    assert caught.value.where == "bounds" and "each of 2 unknowns" in str(caught.value.limit)


@pytest.mark.parametrize("empty", [[1.0, 1.0], [2.0, 1.0], [np.nan, 1.0]])
def test_bounds_without_room_are_refused(empty: list[float]) -> None:
    with pytest.raises(InputError, match="no room") as caught:
        checked_bounds([[0.0, 1.0], empty], 2)
    assert caught.value.where == "bounds[1]"
