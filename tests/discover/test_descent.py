"""Least squares within bounds, on functions whose least is known."""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from jax.flatten_util import ravel_pytree

from thermo.discover import _descent
from thermo.discover._allowance import NOTHING_ALLOWED
from thermo.discover._descent import Ended, Free, descend
from thermo.discover._extended import Extended
from thermo.inverse import Objective

from .lit_objective import objective

Residual = Callable[[jax.Array], jax.Array]


@pytest.fixture(scope="module")
def real() -> Objective:
    return objective()


def least(
    monkeypatch: pytest.MonkeyPatch, real: Objective, function: Residual, begin: list[float],
    logarithm: list[bool], low: float = -np.inf, high: float = np.inf, rival: float = np.inf,
) -> tuple[Ended, int]:  # fmt: skip
    """Where a descent ends whose residual is a function of the point, and its number of trials."""
    trials = 0

    def columns(given: Objective, point: Extended, ways: np.ndarray) -> tuple[np.ndarray, ...]:
        nonlocal trials
        trials += 1
        assert given is real
        flat = ravel_pytree(point)[0]
        return np.asarray(function(flat)), np.asarray(jax.jacobian(function)(flat)) @ ways.T

    monkeypatch.setattr(_descent, "columns", columns)
    count = len(begin)
    free = Free(
        np.arange(count), np.full(count, 0.5), np.full(count, low), np.full(count, high),
        np.array(logarithm),
    )  # fmt: skip
    point = Extended({"some": jnp.asarray(begin)}, ())
    return descend(real, point, free, NOTHING_ALLOWED, rival), trials


def test_two_coefficients_of_exchange_that_hide_each_other_are_told_apart(
    monkeypatch: pytest.MonkeyPatch, real: Objective
) -> None:
    # The sum is seen a thousand times better than the difference, one is fitted by its logarithm.
    def both(at: jax.Array) -> jax.Array:
        one, other = 10 * jnp.exp(at[0]), 10 * at[1]
        return jnp.stack([1000 * (one + other - 10), one - other - 3])

    ended, trials = least(monkeypatch, real, both, [0.0, 0.0], [True, False])
    found = np.asarray(ravel_pytree(ended.point)[0])
    np.testing.assert_allclose([np.exp(found[0]), found[1]], [0.65, 0.35], rtol=1e-2)
    assert ended.loss() < 0.01 and trials <= 5


def test_a_curved_valley_is_followed_to_its_end(
    monkeypatch: pytest.MonkeyPatch, real: Objective
) -> None:
    def valley(at: jax.Array) -> jax.Array:
        return jnp.stack([10 * (at[1] - at[0] ** 2), 3 * (1 - at[0])])

    ended, _ = least(monkeypatch, real, valley, [-1.0, 1.0], [False, False])
    np.testing.assert_allclose(np.asarray(ravel_pytree(ended.point)[0]), 1.0, atol=0.05)


def test_one_that_will_not_reach_its_rival_is_left(
    monkeypatch: pytest.MonkeyPatch, real: Objective
) -> None:
    def far(at: jax.Array) -> jax.Array:
        # Steps are of length one at the most, and the least is a hundred away.
        return 0.1 * (at - 100.0)

    def valley(at: jax.Array) -> jax.Array:
        return jnp.stack([10 * (at[1] - at[0] ** 2), 3 * (1 - at[0]), jnp.array(8.0)])

    _, trials = least(monkeypatch, real, far, [0.0], [False])
    assert trials == 21
    for rival, wanted in [(1.0, 4), (34.0, 21)]:
        _, trials = least(monkeypatch, real, far, [0.0], [False], rival=rival)
        assert trials == wanted, rival
    # Slow while it turns into the valley, and still followed.
    whole, trials = least(monkeypatch, real, valley, [-1.0, 1.0], [False, False])
    for rival in (31.0, 33.0):
        ended, same = least(monkeypatch, real, valley, [-1.0, 1.0], [False, False], rival=rival)
        assert ended.loss() == pytest.approx(whole.loss()) and same == trials


def test_one_that_promises_too_little_is_left_after_its_first_steps(
    monkeypatch: pytest.MonkeyPatch, real: Objective
) -> None:
    def slow(at: jax.Array) -> jax.Array:
        # Each step promises all of the first term, and leaves a tenth of it.
        return jnp.stack([100 * (at[0] - 0.9) ** 3, jnp.array(80.0)])

    whole, trials = least(monkeypatch, real, slow, [0.0], [False])
    assert trials >= 6 and whole.loss() == pytest.approx(3200, abs=0.1)
    ended, few = least(monkeypatch, real, slow, [0.0], [False], rival=1.0)
    assert few == 2 and ended.loss() < 3500
    near, same = least(monkeypatch, real, slow, [0.0], [False], rival=whole.loss())
    assert near.loss() == pytest.approx(whole.loss(), abs=0.1) and same == trials


def test_bounds_hold_and_the_rest_goes_on(monkeypatch: pytest.MonkeyPatch, real: Objective) -> None:
    ended, _ = least(
        monkeypatch, real, lambda at: 10 * (at - jnp.array([3.0, 0.2])), [0.0, 0.0], [False, False],
        -1.0, 1.0,
    )  # fmt: skip
    np.testing.assert_allclose(np.asarray(ravel_pytree(ended.point)[0]), [1.0, 0.2], atol=1e-3)


def test_along_a_bound_the_rest_makes_up_for_what_ends_there(
    monkeypatch: pytest.MonkeyPatch, real: Objective
) -> None:
    # The sum is seen three hundred times better than each, and the least of all lies outside.
    def hidden(at: jax.Array) -> jax.Array:
        return jnp.stack([300 * (at[0] + at[1] - 1), at[0] - 4, at[1] + 3, jnp.asarray(50.0)])

    ended, trials = least(monkeypatch, real, hidden, [0.8, 0.2], [False, False], -0.9, 0.9)
    found = np.asarray(ravel_pytree(ended.point)[0])
    np.testing.assert_allclose(found, [0.9, 0.1], atol=1e-3)
    assert trials <= 4


@given(
    slopes=arrays(float, (5, 3), elements=st.floats(-3, 3)),
    residual=arrays(float, 5, elements=st.floats(-9, 9)),
    begin=arrays(float, 3, elements=st.floats(-1, 1)),
)
def test_no_step_within_the_bounds_promises_more(
    slopes: np.ndarray, residual: np.ndarray, begin: np.ndarray
) -> None:
    wide = np.ones(3)
    free = Free(np.arange(3), 0.7 * wide, -wide, wide, np.arange(3) == 1)
    point = Extended({"some": jnp.asarray(begin)}, ())  # type: ignore[dict-item]
    step, promised = _descent._step(Ended(point, residual, slopes), free, begin, 1e-6)
    low, high = free.ends(begin)
    assert np.all((step >= low - 1e-9) & (step <= high + 1e-9))

    def gain(other: np.ndarray) -> float:
        return 0.5 * float(residual @ residual - np.sum((residual + slopes @ (other / 0.7)) ** 2))

    assert promised == pytest.approx(gain(step), abs=1e-3)
    for share in np.random.default_rng(0).uniform(size=(20, 3)):
        assert gain(low + share * (high - low)) <= promised + 1e-3


def test_a_step_that_leaves_more_is_not_tried_again_nearly_as_long(
    monkeypatch: pytest.MonkeyPatch, real: Objective
) -> None:
    # Linear to the eye at the beginning, and a wall where Newton's step ends.
    def walled(at: jax.Array) -> jax.Array:
        return jnp.stack([30 * at[0], 0.1 * (at[1] - 0.9) + 40 * jnp.maximum(at[1] - 0.2, 0) ** 2])

    ended, trials = least(monkeypatch, real, walled, [0.1, 0.0], [False, False])
    assert ended.loss() < 0.003 and trials <= 9


def test_two_small_gains_in_a_row_are_an_end_however_short_their_steps(
    monkeypatch: pytest.MonkeyPatch, real: Objective
) -> None:
    def narrow(at: jax.Array) -> jax.Array:
        return jnp.stack([100 * (at[1] - at[0] ** 2), 0.3 * (1 - at[0])])

    ended, trials = least(monkeypatch, real, narrow, [-1.0, 1.0], [False, False])
    assert ended.loss() < 0.05 and trials <= 10


def test_a_logarithm_steps_by_the_share_of_its_value_and_never_below_nothing() -> None:
    wide = np.full(2, 9.0)
    free = Free(np.arange(2), np.ones(2), -wide, wide, np.array([True, False]))
    after = free.after(np.array([2.0, 2.0]), np.array([0.5, 0.5]))
    np.testing.assert_allclose(after, [2 + np.log(1.5), 2.5])
    after = free.after(np.array([2.0, 2.0]), np.array([-7.0, -7.0]))
    np.testing.assert_allclose(after, [2 + np.log(0.1), 0.0])
