"""Lengths of the cameras' unit, and how far off they say they are."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.reconstruct import scale_from_depths, scale_from_distances, scale_from_length

TRUE = 0.37  # m a unit


def test_a_length_gives_its_ratio_and_its_deviation() -> None:
    found = scale_from_length(np.zeros(3), np.array([3.0, 0.0, 4.0]), 0.1, 0.001)
    assert found.factor == pytest.approx(0.02)
    assert found.deviation == pytest.approx(0.01)


def depths(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """5 % noise, and 10 % of values too far by up to three times."""
    random = np.random.default_rng(seed)
    group = np.repeat(np.arange(40), 50)
    unit = random.uniform(1.0, 3.0, len(group))
    metres = TRUE * unit * (1 + 0.05 * random.normal(size=len(group)))
    wrong = random.uniform(size=len(group)) < 0.1
    return np.where(wrong, metres * random.uniform(1.2, 3.0, len(group)), metres), unit, group


def test_noise_and_outliers_leave_the_scale_right_within_a_per_cent() -> None:
    off = []
    for seed in range(60):
        found = scale_from_depths(*depths(seed))
        off.append((found.factor - TRUE) / TRUE)
        assert abs(off[-1]) < 0.01
        assert found.deviation < 0.003
    # The deviation that is told is the one that is found.
    told = scale_from_depths(*depths(0)).deviation
    assert 0.7 < np.std(off) / told < 1.4


def test_errors_that_a_picture_shares_count_once() -> None:
    random = np.random.default_rng(1)
    group = np.repeat(np.arange(30), 100)
    metres = (1 + 0.05 * random.normal(size=30))[group]
    found = scale_from_depths(metres, np.ones(len(group)), group)
    assert 0.6 < found.deviation / (0.05 / np.sqrt(30)) < 1.5


def test_pixels_without_depth_count_for_nothing() -> None:
    metres, unit, group = depths(3)
    plain = scale_from_depths(metres, unit, group)
    metres, unit = np.append(metres, [np.nan, 0.0, 5.0]), np.append(unit, [1.0, 1.0, np.nan])
    assert scale_from_depths(metres, unit, np.append(group, [0, 1, 2])).factor == plain.factor


def test_distances_of_cameras_forgive_one_that_is_wrong() -> None:
    random = np.random.default_rng(0)
    places = random.normal(size=(6, 3))
    pairs = np.stack(np.triu_indices(6, 1), axis=1)
    metres = TRUE * np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1)
    metres *= 1 + 0.002 * random.normal(size=len(pairs))
    metres[4] *= 10
    found = scale_from_distances(places, pairs, metres)
    assert found.factor == pytest.approx(TRUE, rel=4 * 0.002 / np.sqrt(15))
    assert 0.3 < found.deviation / (0.002 / np.sqrt(15)) < 2.0


def test_too_little_is_refused() -> None:
    with pytest.raises(InputError, match="three and more"):
        scale_from_distances(np.eye(3), np.array([[0, 1], [1, 2]]), np.ones(2))
    with pytest.raises(InputError, match="no distance"):
        scale_from_length(np.ones(3), np.ones(3), 0.1, 0.0)
