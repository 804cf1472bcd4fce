"""What is allowed for counts as noise, in all columns alike."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from thermo.discover._allowance import NOTHING_ALLOWED, allowance
from thermo.discover._modes import space_modes, time_modes
from thermo.discover._softening import Block, softened

FRAMES, SAMPLES, PRIORS, SPREAD = 13, 17, 3, 2.0
COUNT = FRAMES * SAMPLES + PRIORS
SEEDS = st.integers(0, 10**6)


def one_run() -> Block:
    points = np.random.default_rng(0).uniform(0, 0.02, (SAMPLES, 3))
    part, share = slice(0, FRAMES * SAMPLES), 1 - 1 / np.sqrt(1 + SPREAD)
    return Block(
        "run", part, (FRAMES, SAMPLES), time_modes(FRAMES), space_modes(points), share, 1.05,
        FRAMES * SAMPLES,
    )  # fmt: skip


@given(SEEDS, st.integers(1, 4))
def test_it_whitens_noise_smooth_shapes_and_errors_of_known_shape(seed: int, count: int) -> None:
    make = np.random.default_rng(seed)
    errors = make.normal(size=(COUNT, count)) * 10.0 ** make.uniform(-2, 1, count)
    run = one_run()
    root = allowance([run], errors).whiten(np.eye(COUNT))
    # The inverse of noise and smooth shapes is what softening twice makes of a column.
    soft = softened([run], np.eye(COUNT))
    covariance = np.linalg.inv(soft @ soft) + errors @ errors.T
    np.testing.assert_allclose(root @ covariance @ root.T, np.eye(COUNT), atol=1e-6)


@given(SEEDS)
def test_columns_do_not_know_of_each_other_and_stay_as_they_are(seed: int) -> None:
    make = np.random.default_rng(seed)
    allowed = allowance([one_run()], make.normal(size=(COUNT, 2)))
    values = make.normal(size=(COUNT, 3))
    before = values.copy()
    left = allowed.whiten(values)
    np.testing.assert_array_equal(values, before)
    np.testing.assert_allclose(left[:, :1], allowed.whiten(values[:, :1]), atol=1e-12)


def test_an_error_of_known_shape_is_left_at_its_own_size() -> None:
    make = np.random.default_rng(3)
    error = make.normal(size=(COUNT, 1))
    small, large = (allowance([], size * error).whiten(size * error) for size in (1e-4, 1e4))
    np.testing.assert_allclose(small, 1e-4 * error, rtol=1e-4)
    assert np.linalg.norm(large) < 1.0 + 1e-6


def test_with_nothing_allowed_noise_stays_noise() -> None:
    values = np.random.default_rng(4).normal(size=(COUNT, 2))
    np.testing.assert_array_equal(NOTHING_ALLOWED.whiten(values), values)
