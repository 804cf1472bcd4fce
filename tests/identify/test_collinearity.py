"""Unknowns that look alike: closed forms, the smallest sets, and which one to measure."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.identify import alike
from thermo.inverse import Sensitivity

NAMES = ("conductivity", "convection", "emissivity", "volumetric_heat_capacity", "diffusivity")


def at(columns: np.ndarray) -> Sensitivity:
    """Slopes of one frame, a row a sample."""
    return Sensitivity(NAMES[: columns.shape[1]], {"run": columns[None]}, {"run": 0.1})


def turned(angle: float) -> np.ndarray:
    """Two effects of different size, at an angle."""
    return np.array([[1.0, 30 * np.cos(angle)], [0.0, 30 * np.sin(angle)], [0.0, 0.0]])


@given(angle=st.floats(1e-4, 0.049))
@settings(max_examples=25, deadline=None)
def test_two_effects_have_their_closed_form(angle: float) -> None:
    (one,) = alike(at(turned(angle)))
    assert one.names == ("conductivity", "convection")
    assert one.index == pytest.approx(1 / np.sqrt(1 - np.cos(angle)), rel=1e-3)
    # Larger effects of the same shape are as much alike.
    (again,) = alike(at(turned(angle) * [5.0, 0.1]))
    assert again.index == pytest.approx(one.index, rel=1e-3)


def test_effects_at_a_wide_angle_are_not_alike() -> None:
    assert alike(at(turned(0.2))) == []


def test_the_smallest_set_is_named_and_what_to_measure() -> None:
    columns = np.random.default_rng(0).standard_normal((40, 4))
    columns[:, 2] = columns[:, 0] + 0.3 * columns[:, 1] + 1e-3 * columns[:, 2]
    (one,) = alike(at(columns))
    assert set(one.names) == {"conductivity", "convection", "emissivity"}
    # Without the convection the other two are still nearly the same.
    assert one.measure in ("conductivity", "emissivity") and one.index > 100


def test_more_than_four_that_are_alike_together_are_found() -> None:
    columns = np.random.default_rng(1).standard_normal((40, 5))
    columns[:, 4] = columns[:, :4].sum(1) + 1e-3 * columns[:, 4]
    (one,) = alike(at(columns))
    assert set(one.names) == set(NAMES)


def test_what_no_run_shows_is_like_nothing() -> None:
    columns = turned(0.01)
    hidden = np.column_stack([columns, np.zeros(3)])
    (one,) = alike(at(hidden))
    assert one.names == ("conductivity", "convection")


def test_equal_effects_have_a_finite_index() -> None:
    (one,) = alike(at(turned(0.0)))
    assert np.isfinite(one.index) and one.index > 1e6


def test_many_unknowns_are_looked_at_in_seconds() -> None:
    random = np.random.default_rng(2)
    columns = random.standard_normal((400, 150))
    columns[:, 7] = columns[:, 3] + columns[:, 5] + 1e-3 * columns[:, 7]
    many = Sensitivity(("conductivity",) * 150, {"run": columns[None]}, {"run": 0.1})
    begun = time.perf_counter()
    (one,) = alike(many)
    assert one.names == ("conductivity[3]", "conductivity[5]", "conductivity[7]")
    assert time.perf_counter() - begun < 30
