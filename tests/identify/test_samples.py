"""Draws against distributions whose moments are known."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.identify import _samples as module
from thermo.identify import samples

WIDE = np.tile([-50.0, 50.0], (3, 1))


def linear(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    return random.standard_normal((20, 3)) @ np.diag([1.0, 10.0, 0.1]), random.standard_normal(20)


def test_draws_of_a_linear_model_are_those_of_its_normal_distribution() -> None:
    pytest.importorskip("blackjax")
    matrix, right = linear()
    steps: list[int] = []
    found = samples(
        lambda at: (matrix @ at - right, matrix), np.zeros(3), bounds=WIDE, count=1500,
        on_draw=steps.append,
    )  # fmt: skip
    assert found.unknowns.shape == (1500, 3) and steps[-1] == 1500 + 375
    covariance = np.linalg.inv(matrix.T @ matrix)
    deviation = np.sqrt(np.diagonal(covariance))
    middle = np.linalg.lstsq(matrix, right)[0]
    assert found.effective.min() > 300 and 0.5 < found.accepted < 1
    error = deviation / np.sqrt(found.effective)
    assert np.all(np.abs(found.unknowns.mean(0) - middle) < 4 * error)
    assert found.unknowns.std(0) == pytest.approx(deviation, rel=0.15)
    assert found.linear == pytest.approx(1.96 * deviation, rel=0.01)
    ends = found.intervals()
    assert (ends[:, 1] - ends[:, 0]) / 2 == pytest.approx(found.linear, rel=0.15)


def test_a_bent_posterior_is_not_the_one_of_its_slopes() -> None:
    pytest.importorskip("blackjax")

    # exp(u) is known as 1 +- 0.5: log values have a long tail towards the small ones.
    def model(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (np.exp(at) - 1) / 0.5, np.exp(at)[None] / 0.5

    found = samples(model, np.array([0.3]), bounds=np.array([[-2.0, 2.0]]), count=1500)
    grid = np.linspace(-2, 2, 20001)
    weight = np.exp(-0.5 * ((np.exp(grid) - 1) / 0.5) ** 2)
    share = np.cumsum(weight) / weight.sum()
    wanted = np.interp([0.025, 0.975], share, grid)
    low, high = found.intervals()[0]
    assert low == pytest.approx(wanted[0], abs=0.15)
    assert high == pytest.approx(wanted[1], abs=0.06)
    assert low < -1.3 * found.linear[0], "the slopes alone make it narrower"
    assert np.all(np.abs(found.unknowns) <= 2.0)


def test_draws_are_repeated_by_their_seed() -> None:
    pytest.importorskip("blackjax")
    matrix, right = linear()
    one, same, other = (
        samples(lambda at: (matrix @ at - right, matrix), np.zeros(3), bounds=WIDE, count=10,
                seed=seed).unknowns
        for seed in (1, 1, 2)
    )  # fmt: skip
    assert np.array_equal(one, same) and not np.array_equal(one, other)


def test_what_cannot_be_drawn_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def model(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        raise AssertionError("work began")

    with pytest.raises(InputError, match="so few draws"):
        samples(model, np.zeros(3), bounds=WIDE, count=5)
    with pytest.raises(InputError, match="bounds on both sides"):
        samples(model, np.zeros(3), bounds=np.tile([-np.inf, 1.0], (3, 1)))
    with pytest.raises(InputError, match="not those of the unknowns"):
        samples(model, np.zeros(2), bounds=WIDE)
    monkeypatch.setattr(module, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="not here") as caught:
        samples(model, np.zeros(3), bounds=WIDE)
    assert "sampling" in caught.value.remedy


def test_bounds_that_leave_no_room_are_told_of() -> None:
    pytest.importorskip("blackjax")

    def model(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.array([1e8 * (at[0] - 7.0)]), np.array([[1e8]])

    with pytest.raises(InputError, match="no step") as caught:
        samples(model, np.array([0.5]), bounds=np.array([[0.0, 1.0]]), count=10)
    assert "lies at 1" in caught.value.limit
