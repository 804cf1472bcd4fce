"""Basins: one valley, two valleys, a flat one, and noise beside the optimiser."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.identify import basins

ROWS = 50


def line(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal((ROWS, 2))


def linear(matrix: np.ndarray, truth: np.ndarray):  # noqa: ANN201
    return lambda at: (matrix @ (at - truth), matrix)


def two_valleys(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least at 1, and at -1 by 4 higher."""
    u = at[0]
    return (
        np.array([10 * (u**2 - 1), u - 1.0]),
        np.array([[20 * u], [1.0]]),
    )


STARTS = np.array([[-2.0, 3.0], [0.0, 0.0], [4.0, -1.0]])


def test_a_linear_problem_has_one_basin_and_its_noise_is_as_foretold() -> None:
    matrix, truth = line(), np.array([0.5, -0.2])
    found = basins(linear(matrix, truth), STARTS, draws=200, seed=3)
    assert found.centres == pytest.approx(truth[None], abs=1e-4)
    assert found.shares() == pytest.approx([1.0]) and found.chi2 == pytest.approx([0.0], abs=1e-3)
    wanted = np.diagonal(np.linalg.inv(matrix.T @ matrix))
    assert found.linear == pytest.approx(wanted, rel=1e-9)
    # 200 draws know a variance to a tenth.
    assert found.noise == pytest.approx(wanted, rel=0.3) and found.noise_as_foretold().all()
    assert np.all(found.optimiser_share() < 1e-3)


def test_two_valleys_are_two_basins_the_lower_first() -> None:
    starts = np.array([[-3.0], [-0.5], [0.5], [2.0], [3.0]])
    found = basins(two_valleys, starts)
    assert len(found.centres) == 2 and found.chi2[0] < 1e-3 < 3 < found.chi2[1]
    assert found.centres[:, 0] == pytest.approx([1.0, -1.0], abs=0.01)
    assert found.of_start.tolist() == [1, 1, 0, 0, 0]
    assert found.shares() == pytest.approx([0.6, 0.4])
    assert not np.any(found.noise) and found.noise_as_foretold().all()


def test_two_valleys_are_variance_of_the_optimiser() -> None:
    found = basins(two_valleys, np.array([[-1.5], [1.5]]), draws=20)
    assert found.optimiser == pytest.approx([1.0], rel=0.1)
    assert found.optimiser_share()[0] > 0.95


def test_noise_that_moves_by_other_than_the_slopes_foretell_is_seen() -> None:
    matrix = line()[:, :1]

    def bent(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        # All but flat where it is least, so that the slopes there foretell far too much.
        u = at[0]
        return matrix[:, 0] * (5 * u**3 + 1e-3 * u), matrix * (15 * u**2 + 1e-3)

    found = basins(bent, np.array([[0.3]]), draws=30)
    assert not found.noise_as_foretold().all()


def test_bounds_hold_and_what_has_no_effect_stays() -> None:
    matrix = line() * np.array([1.0, 0.0])
    limits = np.array([[0.0, 1.0], [-5.0, 5.0]])
    found = basins(linear(matrix, np.array([3.0, 0.0])), STARTS, bounds=limits)
    assert np.all(found.centres[:, 0] == 1.0)
    assert np.isinf(found.linear[1]) and len(found.centres) == 1
    assert found.of_start.tolist() == [0, 0, 0]
    with pytest.raises(InputError, match="no room"):
        basins(linear(matrix, np.zeros(2)), STARTS, bounds=[[1.0, 0.0], [-5.0, 5.0]])


def test_fits_that_settle_nowhere_belong_to_no_basin() -> None:
    def downhill(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        # The slope has the wrong sign: no step helps.
        return np.array([at[0] + 10.0]), np.array([[-1.0]])

    found = basins(downhill, np.array([[0.0], [1.0]]))
    assert found.of_start.tolist() == [-1, -1] and found.shares() == pytest.approx([0.0])
    assert found.centres[0, 0] == pytest.approx(0.0)
