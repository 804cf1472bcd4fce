"""What nuisances leave, against dense matrices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.discover._projection import Projection, projection

VALUES = 24


def drawn(seed: int, free: int, believed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Columns that are free, columns believed to be of amplitude one, and some to be projected."""
    make = np.random.default_rng(seed)
    # Columns of very different lengths, as slopes by different quantities are.
    sizes = 10.0 ** make.uniform(-2, 2, free)
    return (
        make.normal(size=(VALUES, free)) * sizes,
        make.normal(size=(VALUES, believed)) * make.uniform(0.1, 5, believed),
        make.normal(size=(VALUES, 3)),
    )


def dense(free: np.ndarray, believed: np.ndarray) -> np.ndarray:
    """C^-1 - C^-1 A (A' C^-1 A)^-1 A' C^-1 with C = I + B B'."""
    inverse = np.linalg.inv(np.eye(VALUES) + believed @ believed.T)
    if not free.shape[1]:
        return inverse
    pulled = inverse @ free
    return inverse - pulled @ np.linalg.solve(free.T @ pulled, pulled.T)


SEEDS = st.integers(0, 10**6)


@given(SEEDS, st.integers(0, 4), st.integers(0, 4))
def test_it_is_the_dense_inverse_on_what_the_free_columns_leave(
    seed: int, free: int, believed: int
) -> None:
    some, known, of = drawn(seed, free, believed)
    if free + believed == 0:
        return
    found = projection(some, known).left(of)
    np.testing.assert_allclose(found, dense(some, known) @ of, atol=1e-8)


@given(SEEDS, st.integers(1, 4), st.integers(0, 4))
def test_nothing_is_left_of_the_free_columns(seed: int, free: int, believed: int) -> None:
    some, known, _ = drawn(seed, free, believed)
    left = projection(some, known).left(some)
    assert np.abs(left / np.linalg.norm(some, axis=0)).max() < 1e-9


@given(SEEDS, st.integers(1, 4))
def test_a_believed_column_counts_for_less_and_not_for_nothing(seed: int, believed: int) -> None:
    some, known, _ = drawn(seed, 0, believed)
    column = known[:, :1]
    told = float((column.T @ projection(some, known).left(column))[0, 0])
    # b' (I + B B')^-1 b < 1 for each column b of B.
    assert 0 < told < 1
    alone = float((column.T @ projection(some, column).left(column))[0, 0])
    square = float((column**2).sum())
    assert alone == pytest.approx(square / (1 + square), rel=1e-9)


def test_what_is_left_is_symmetric_and_positive() -> None:
    some, known, _ = drawn(3, 3, 2)
    whole = projection(some, known).left(np.eye(VALUES))
    np.testing.assert_allclose(whole, whole.T, atol=1e-10)
    values = np.linalg.eigvalsh(whole)
    assert values.min() > -1e-9 and values.max() < 1 + 1e-9
    assert (values < 1e-9).sum() == 3, "three directions are gone"


def test_the_part_and_what_is_left_make_the_whole() -> None:
    some, known, of = drawn(4, 2, 2)
    found = projection(some, known)
    np.testing.assert_allclose(found.left(of) + found.columns @ found.part(of), of, atol=1e-12)
    one = found.left(of[:, 0])
    np.testing.assert_allclose(one, found.left(of)[:, 0], atol=1e-12)


@given(SEEDS)
def test_columns_of_no_size_are_left_out(seed: int) -> None:
    some, known, of = drawn(seed, 2, 2)
    nothing = np.zeros((VALUES, 1))
    padded = projection(np.c_[nothing, some], np.c_[known, nothing])
    assert isinstance(padded, Projection) and padded.columns.shape[1] == 4
    np.testing.assert_allclose(padded.left(of), projection(some, known).left(of), atol=1e-12)


def test_two_free_columns_that_are_alike_count_once() -> None:
    some, known, of = drawn(5, 2, 2)
    twice = np.c_[some, 3 * some[:, :1]]
    np.testing.assert_allclose(
        projection(twice, known).left(of), projection(some, known).left(of), atol=1e-3
    )


def test_with_no_nuisance_at_all_everything_is_left() -> None:
    none, _, of = drawn(6, 0, 0)
    np.testing.assert_array_equal(projection(none, none).left(of), of)
