"""Steps in a box: as least squares where the box is wide, best on its edge where it is not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.identify._boxed_step import boxed_step

WIDE = np.array([[-np.inf, np.inf]] * 4)


def problem(seed: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    return random.standard_normal(30), random.standard_normal((30, 4)) * [1e-3, 1.0, 20.0, 5.0]


def left(residual: np.ndarray, jacobian: np.ndarray, step: np.ndarray) -> float:
    return float(np.sum((residual + jacobian @ step) ** 2))


@given(seed=st.integers(0, 999))
@settings(max_examples=20, deadline=None)
def test_a_wide_box_leaves_the_least_squares_step(seed: int) -> None:
    residual, jacobian = problem(seed)
    step, promise = boxed_step(residual, jacobian, WIDE)
    best = np.linalg.lstsq(jacobian, -residual, rcond=None)[0]
    assert step == pytest.approx(best, rel=1e-6, abs=1e-9)
    fall = residual @ residual - left(residual, jacobian, best)
    assert promise == pytest.approx(fall, rel=1e-6)


@given(seed=st.integers(0, 999), wide=st.floats(1e-3, 1.0))
@settings(max_examples=20, deadline=None)
def test_no_step_within_the_box_leaves_less(seed: int, wide: float) -> None:
    residual, jacobian = problem(seed)
    box = wide * np.array([[-1.0, 1.0], [0.0, 1.0], [-1.0, 0.0], [0.0, 0.0]])
    step, promise = boxed_step(residual, jacobian, box)
    assert np.all((step >= box[:, 0]) & (step <= box[:, 1])) and step[3] == 0.0
    least = left(residual, jacobian, step)
    assert promise == pytest.approx(residual @ residual - least, rel=1e-9, abs=1e-9)
    for other in np.random.default_rng(seed).uniform(box[:, 0], box[:, 1], (50, 4)):
        assert left(residual, jacobian, other) >= least - 1e-9


def test_what_the_slopes_do_not_show_is_left_alone() -> None:
    residual, jacobian = problem(0)
    alike = jacobian[:, [1, 1, 2, 3]]
    alike[:, 3] = 0.0
    step, _ = boxed_step(residual, alike, WIDE)
    assert step[0] == pytest.approx(step[1], rel=1e-3) and step[3] == 0.0


def test_an_empty_box_leaves_all_where_it_is() -> None:
    step, promise = boxed_step(*problem(0), np.zeros((4, 2)))
    assert not step.any() and promise == 0.0
