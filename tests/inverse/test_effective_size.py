"""Independent values in a correlated residual: against closed forms, and where there is nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist

from thermo.inverse._effective_size import repeats

FRAMES, SAMPLES = 200, 300


def scattered(count: int = SAMPLES) -> np.ndarray:
    """Points on a flat square of side 1."""
    return np.random.default_rng(1).uniform(size=(count, 3)) * [1, 1, 0]


def counted(error: np.ndarray, points: np.ndarray | None = None) -> float:
    points = scattered(error.shape[1]) if points is None else points
    return repeats(error, np.ones(error.shape, bool), points)


@pytest.mark.parametrize("seed", range(3))
def test_independent_values_count_once(seed: int) -> None:
    error = np.random.default_rng(seed).standard_normal((FRAMES, SAMPLES))
    assert 1.0 <= counted(error) < 1.1


@pytest.mark.parametrize("r", [0.3, 0.6, 0.9])
def test_autoregressive_noise_has_its_closed_form(r: float) -> None:
    random = np.random.default_rng(0)
    error = [random.standard_normal(SAMPLES)]
    for _ in range(FRAMES):
        error.append(r * error[-1] + np.sqrt(1 - r**2) * random.standard_normal(SAMPLES))
    assert counted(np.array(error)) == pytest.approx((1 + r) / (1 - r), rel=0.15)


def test_a_fixed_pattern_counts_once_a_sample() -> None:
    pattern = np.random.default_rng(0).standard_normal(SAMPLES)
    # Every frame says the same: 1 + 2 sum (1 - lag / frames) is their number.
    assert counted(np.tile(pattern, (FRAMES, 1))) == pytest.approx(FRAMES, rel=0.25)


def test_correlation_over_the_surface_has_its_closed_form() -> None:
    points, random = scattered(), np.random.default_rng(0)
    near = np.exp(-cdist(points, points) / 0.05)
    error = random.standard_normal((FRAMES, SAMPLES)) @ np.linalg.cholesky(near).T
    # Variance of the sum over samples, against that of independent ones.
    assert counted(error, points) == pytest.approx(near.sum() / SAMPLES, rel=0.2)


def test_many_samples_count_like_the_few_of_them_that_are_looked_at() -> None:
    points, random = scattered(3000), np.random.default_rng(0)
    # Cells of a chessboard that share their error: one value in 3000 / 100.
    cell = (np.floor(points[:, 0] * 10) * 10 + np.floor(points[:, 1] * 10)).astype(int)
    error = random.standard_normal((40, 100))[:, cell]
    assert counted(error, points) == pytest.approx(30, rel=0.25)


@given(
    scale=st.floats(1e-6, 1e6),
    shift=st.integers(0, 2**31),
)
@settings(max_examples=20, deadline=None)
def test_neither_scale_nor_order_of_the_samples_counts(scale: float, shift: int) -> None:
    random = np.random.default_rng(shift)
    error, points = random.standard_normal((12, 20)).cumsum(0), random.uniform(size=(20, 3))
    order = random.permutation(20)
    again = counted(scale * error[:, order], points[order])
    assert again == pytest.approx(counted(error, points), rel=1e-6)


def test_what_is_not_known_does_not_count() -> None:
    error = np.random.default_rng(0).standard_normal((FRAMES, SAMPLES))
    known = np.random.default_rng(1).uniform(size=error.shape) > 0.3
    wild = np.where(known, error, 1e9)
    assert repeats(wild, known, scattered()) < 1.2


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (40, 1), (3, 4)])
def test_small_and_empty_residuals(shape: tuple[int, int]) -> None:
    assert counted(np.zeros(shape)) == 1.0
    assert counted(np.ones(shape)) >= 1.0
