from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging._interpolate import interpolated, sample_weights

RANDOM = np.random.default_rng(5)
SAMPLES, VERTICES = RANDOM.normal(size=(40, 3)), RANDOM.normal(size=(90, 3))


def test_two_samples_weigh_by_inverse_distance() -> None:
    samples = np.array([[0.0, 0, 0], [4.0, 0, 0], [50.0, 0, 0]])
    found = sample_weights(samples, np.array([[1.0, 0, 0]]), k=2)
    assert dict(zip(found.nearest[0].tolist(), found.weights[0], strict=True)) == pytest.approx(
        {0: 0.75, 1: 0.25}
    )
    values = np.array([[300.0, 340.0, 1e3], [200.0, 240.0, 1e3]])
    np.testing.assert_allclose(interpolated(found, values), [[310.0], [210.0]], rtol=1e-15)


@given(k=st.integers(1, 40), value=st.floats(200.0, 2000.0))
def test_constants_stay(k: int, value: float) -> None:
    found = sample_weights(SAMPLES, VERTICES, k=k)
    assert (found.weights >= 0).all()
    np.testing.assert_allclose(found.weights.sum(axis=1), 1.0, rtol=1e-15 * 10)
    np.testing.assert_allclose(
        interpolated(found, np.full((2, 40), value)), np.full((2, 90), value), rtol=1e-14
    )


@given(k=st.integers(1, 12))
def test_a_sample_on_a_vertex_gives_its_value_exactly(k: int) -> None:
    values = RANDOM.uniform(270.0, 330.0, (3, 40))
    got = interpolated(sample_weights(SAMPLES, SAMPLES[::-1].copy(), k=k), values)
    np.testing.assert_array_equal(got, values[:, ::-1])


def test_close_samples_do_not_overflow() -> None:
    tiny = np.array([[1e-310, 0, 0], [1.0, 0, 0]])
    found = sample_weights(tiny, np.zeros((1, 3)), k=2)
    assert np.isfinite(found.weights).all() and found.weights.max() == pytest.approx(1.0)


def test_between_the_least_and_the_greatest() -> None:
    values = RANDOM.uniform(270.0, 330.0, (3, 40))
    got = interpolated(sample_weights(SAMPLES, VERTICES), values)
    assert got.shape == (3, 90)
    assert (got >= values.min(axis=1)[:, None]).all() and (got <= values.max(axis=1)[:, None]).all()


@pytest.mark.parametrize("k", [0, 41, True])
def test_numbers_of_samples_that_are_not_there(k: int) -> None:
    with pytest.raises(InputError, match="from 1 to 40"):
        sample_weights(SAMPLES, VERTICES, k=k)


def test_values_that_do_not_fit() -> None:
    found = sample_weights(SAMPLES, VERTICES)
    with pytest.raises(InputError, match="40 samples"):
        interpolated(found, np.zeros((2, 39)))
    values = np.full((2, 40), 300.0)
    values[1, 7] = np.nan
    with pytest.raises(InputError, match="frame 1, sample 7"):
        interpolated(found, values)
    with pytest.raises(InputError, match="number 0"):
        sample_weights(SAMPLES * np.nan, VERTICES)
