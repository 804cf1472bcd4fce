"""Smooth shapes in time and over the samples: orthonormal, and large enough for what is smooth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from thermo.discover._modes import IN_SPACE, IN_TIME, space_modes, time_modes

Shape = Callable[[np.ndarray], np.ndarray]


def on_a_box(count: int = 120) -> np.ndarray:
    """Points on the sides of a box [m]."""
    make = np.random.default_rng(0)
    points = make.uniform(0, 1, (count, 3))
    axis, end = make.integers(0, 3, count), make.integers(0, 2, count)
    points[np.arange(count), axis] = end
    return points * [0.02, 0.012, 0.008]


def captured(modes: np.ndarray, values: np.ndarray) -> float:
    """Share of the energy of values that the modes hold [1]."""
    return float(((modes.T @ values) ** 2).sum() / (values**2).sum())


@given(st.integers(1, 60))
def test_shapes_in_time_are_orthonormal(frames: int) -> None:
    modes = time_modes(frames)
    assert modes.shape == (frames, min(IN_TIME, frames))
    np.testing.assert_allclose(modes.T @ modes, np.eye(modes.shape[1]), atol=1e-12)
    assert captured(modes, np.ones(frames)) == pytest.approx(1.0)


@given(st.integers(2, 60), st.integers(0, 1000))
def test_shapes_over_samples_are_orthonormal(samples: int, seed: int) -> None:
    modes = space_modes(np.random.default_rng(seed).uniform(0, 0.1, (samples, 3)))
    assert modes.shape == (samples, min(IN_SPACE, samples))
    np.testing.assert_allclose(modes.T @ modes, np.eye(modes.shape[1]), atol=1e-10)


def test_one_sample_has_one_shape() -> None:
    np.testing.assert_allclose(np.abs(space_modes(np.zeros((1, 3)))), [[1.0]])


@pytest.mark.parametrize(
    "shape",
    [
        lambda t: np.exp(-3 * t),
        lambda t: 1 - np.exp(-8 * t),
        lambda t: np.minimum(t, 0.6),
        lambda t: np.where(t < 0.6, 1 - np.exp(-5 * t), np.exp(-5 * (t - 0.6))),
        lambda t: np.sin(9 * t),
    ],
    ids=["cooling", "warming", "kink", "lamp", "wave"],
)
def test_what_changes_slowly_lies_in_the_shapes_in_time(shape: Shape) -> None:
    assert captured(time_modes(80), shape(np.linspace(0, 1, 80))) > 0.95


@pytest.mark.parametrize(
    "shape",
    [
        lambda p: np.ones(len(p)),
        lambda p: p[:, 0],
        lambda p: p[:, 2] - 0.5 * p[:, 1],
        lambda p: np.exp(-((p - [0.013, 0.006, 0.008]) ** 2).sum(1) / (2 * 0.005**2)),
        lambda p: np.cos(np.pi * p[:, 0] / 0.02),
    ],
    ids=["constant", "along_x", "slanted", "spot", "wave"],
)
def test_what_is_smooth_lies_in_the_shapes_over_samples(shape: Shape) -> None:
    points = on_a_box()
    assert captured(space_modes(points), shape(points)) > 0.95


def test_shapes_do_not_depend_on_the_size_or_the_order_of_the_points() -> None:
    points = on_a_box(40)
    order = np.random.default_rng(1).permutation(40)
    first = space_modes(points)
    for other, back in [
        (space_modes(10 * points + 3.0), np.arange(40)),
        (space_modes(points[order]), order),
    ]:
        # Shapes of equal smoothness may be mixed: what they span is the same.
        np.testing.assert_allclose(first[back] @ first[back].T, other @ other.T, atol=1e-6)


def test_noise_has_coefficients_of_variance_one() -> None:
    frames, points, draws = 30, on_a_box(50), 400
    along, across = time_modes(frames), space_modes(points)
    noise = np.random.default_rng(2).normal(size=(draws, frames, len(points)))
    found = np.einsum("ft,dfs,sm->dtm", along, noise, across)
    count = draws * IN_TIME * IN_SPACE
    told = float((found**2).sum())
    assert chi2.ppf(1e-4, count) < told < chi2.ppf(1 - 1e-4, count)
    each = (found**2).sum(0)
    assert chi2.ppf(1e-6, draws) < each.min() and each.max() < chi2.ppf(1 - 1e-6, draws)
    assert captured(across, noise[0, 0]) < 0.7, "most of the noise is outside"
