"""What nuisances leave, against dense matrices."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from thermo.discover._projection import Projection, projection

VALUES = 24


def drawn(seed: int, free: int) -> tuple[np.ndarray, np.ndarray]:
    """Columns that are free, and some to be projected."""
    make = np.random.default_rng(seed)
    # Columns of very different lengths, as slopes by different quantities are.
    sizes = 10.0 ** make.uniform(-2, 2, free)
    return make.normal(size=(VALUES, free)) * sizes, make.normal(size=(VALUES, 3))


SEEDS = st.integers(0, 10**6)


@given(SEEDS, st.integers(1, 4))
def test_it_is_what_least_squares_leaves(seed: int, free: int) -> None:
    some, of = drawn(seed, free)
    wanted = of - some @ np.linalg.lstsq(some, of, rcond=None)[0]
    np.testing.assert_allclose(projection(some).left(of), wanted, atol=1e-8)


@given(SEEDS, st.integers(1, 4))
def test_nothing_is_left_of_the_free_columns(seed: int, free: int) -> None:
    some, _ = drawn(seed, free)
    left = projection(some).left(some)
    assert np.abs(left / np.linalg.norm(some, axis=0)).max() < 1e-9


def test_what_is_left_is_symmetric_and_positive() -> None:
    some, _ = drawn(3, 3)
    whole = projection(some).left(np.eye(VALUES))
    np.testing.assert_allclose(whole, whole.T, atol=1e-10)
    values = np.linalg.eigvalsh(whole)
    assert values.min() > -1e-9 and values.max() < 1 + 1e-9
    assert (values < 1e-9).sum() == 3, "three directions are gone"


def test_the_part_and_what_is_left_make_the_whole() -> None:
    some, of = drawn(4, 2)
    found = projection(some)
    np.testing.assert_allclose(found.left(of) + found.columns @ found.part(of), of, atol=1e-12)
    one = found.left(of[:, 0])
    np.testing.assert_allclose(one, found.left(of)[:, 0], atol=1e-12)


@given(SEEDS)
def test_columns_of_no_size_are_left_out(seed: int) -> None:
    some, of = drawn(seed, 2)
    padded = projection(np.c_[np.zeros((VALUES, 1)), some])
    assert isinstance(padded, Projection) and padded.columns.shape[1] == 2
    np.testing.assert_allclose(padded.left(of), projection(some).left(of), atol=1e-12)


def test_two_free_columns_that_are_alike_count_once() -> None:
    some, of = drawn(5, 2)
    twice = np.c_[some, 3 * some[:, :1]]
    np.testing.assert_allclose(projection(twice).left(of), projection(some).left(of), atol=1e-3)


def test_with_nothing_free_everything_is_left() -> None:
    none, of = drawn(6, 0)
    np.testing.assert_array_equal(projection(none).left(of), of)
