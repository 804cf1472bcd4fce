"""Directions in words: ratios, powers, single unknowns, and no more vectors than needed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.identify._combination import combinations

NAMES = ("k", "rho c", "h", "eps")


def found(*columns: list[float]) -> list[dict[str, float]]:
    return [one.weights for one in combinations(NAMES, np.array(columns, float).T)]


def words(*columns: list[float]) -> list[str]:
    return [one.words() for one in combinations(NAMES, np.array(columns, float).T)]


def test_a_common_factor_leaves_ratios() -> None:
    (said,) = words([0.5, 0.5, 0.502, 0.0])
    assert said == (
        "k, rho c and h may all be multiplied by one factor: only their ratios are determined"
    )


def test_powers_are_written_as_simple_fractions() -> None:
    assert words([-0.4, 0.2, 0.0, 0.0]) == [
        "k may be multiplied by any factor f together with rho c by f^-1/2"
    ]
    assert "by f^0.43" in words([0.0, 1.0, 0.43, 0.0])[0]


def test_what_the_data_never_see_stands_alone() -> None:
    # The two directions mix what is simple: eps by itself, and k with h.
    both = found([0.3, 0.0, 0.3, 0.7], [0.4, 0.0, 0.4, -0.2])
    assert {frozenset(one) for one in both} == {frozenset({"k", "h"}), frozenset({"eps"})}
    assert "eps is not determined" in words([0.3, 0.0, 0.3, 0.7], [0.4, 0.0, 0.4, -0.2])


def test_no_direction_has_no_words() -> None:
    assert combinations(NAMES, np.zeros((4, 0))) == []


@given(seed=st.integers(0, 999), count=st.integers(1, 3))
@settings(max_examples=40, deadline=None)
def test_the_vectors_span_the_directions(seed: int, count: int) -> None:
    space = np.random.default_rng(seed).standard_normal((4, count))
    made = [[one.get(name, 0.0) for name in NAMES] for one in found(*space.T)]
    assert np.linalg.matrix_rank(made) == count
    outside = np.array(made).T - space @ np.linalg.lstsq(space, np.array(made).T, rcond=None)[0]
    # Exponents that say nothing are left out.
    assert np.abs(outside).max() < 0.04
    assert all(
        max(one.values(), key=abs) == pytest.approx(1.0, abs=0.03) for one in found(*space.T)
    )
