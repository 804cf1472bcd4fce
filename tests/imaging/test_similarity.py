"""Similarities: closed forms, inverses, products, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging._similarity import Similarity, motion_about, similarity_about

NUMBERS = st.floats(-1.0, 1.0)
MOTIONS = st.lists(NUMBERS, min_size=7, max_size=7).map(np.array)
POINTS = np.random.default_rng(0).normal(size=(5, 3))


def test_a_quarter_turn_twice_as_large() -> None:
    turn = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    moved = Similarity(turn, [0.0, 0.0, 3.0], 2.0).apply(np.array([[1.0, 0.0, 0.5]]))
    np.testing.assert_allclose(moved, [[0.0, 2.0, 4.0]], atol=1e-12)


def test_nothing_given_moves_nothing() -> None:
    np.testing.assert_allclose(Similarity().apply(POINTS), POINTS)


@given(MOTIONS, MOTIONS, MOTIONS)
def test_products_and_inverses(one: np.ndarray, other: np.ndarray, place: np.ndarray) -> None:
    centre = place[:3]
    first, second = similarity_about(centre, one), similarity_about(-centre, other)
    both = second.after(first)
    np.testing.assert_allclose(both.apply(POINTS), second.apply(first.apply(POINTS)), atol=1e-9)
    np.testing.assert_allclose(both.inverse().apply(both.apply(POINTS)), POINTS, atol=1e-9)
    assert both.scale == pytest.approx(np.exp(one[6] + other[6]))


@given(MOTIONS, MOTIONS)
def test_a_motion_is_read_back(motion: np.ndarray, place: np.ndarray) -> None:
    centre = place[:3]
    found = similarity_about(centre, motion)
    np.testing.assert_allclose(found.apply(centre[None])[0], centre + motion[3:6], atol=1e-12)
    np.testing.assert_allclose(motion_about(centre, found), motion, atol=1e-9)


def test_distances_grow_by_the_scale_alone() -> None:
    motion = np.array([0.3, -0.2, 0.9, 0.1, 0.2, 0.3, np.log(1.5)])
    moved = similarity_about(np.ones(3), motion).apply(POINTS)
    before = np.linalg.norm(POINTS[1:] - POINTS[0], axis=1)
    np.testing.assert_allclose(np.linalg.norm(moved[1:] - moved[0], axis=1), 1.5 * before)


@pytest.mark.parametrize(
    ("rotation", "shift", "scale", "words"),
    [
        (np.diag([1.0, 1.0, -1.0]), None, 1.0, "mirror image"),
        (2 * np.eye(3), None, 1.0, "does not turn alone"),
        (np.eye(4), None, 1.0, "shape (4, 4)"),
        (None, [1.0, 2.0], 1.0, "shape (2,)"),
        (None, [1.0, np.nan, 0.0], 1.0, "no transformation"),
        (None, None, 0.0, "above 0"),
        (None, None, -1.0, "above 0"),
    ],
)
def test_others_are_refused(rotation: object, shift: object, scale: float, words: str) -> None:
    with pytest.raises(InputError, match="limit") as caught:
        Similarity(rotation, shift, scale, where="guess")  # type: ignore[arg-type]
    assert words in str(caught.value)
    assert str(caught.value).startswith("guess")
