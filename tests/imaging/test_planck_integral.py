"""The series of the fractional function against quadrature and its known limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from thermo.imaging._planck_integral import planck_integral


def integrand(t: float) -> float:
    return t**3 / np.expm1(t) if t > 0 else 0.0


@given(st.floats(1e-3, 40.0), st.floats(1.01, 30.0))
def test_it_is_the_integral(low: float, ratio: float) -> None:
    high = min(low * ratio, 600.0)
    exact = quad(integrand, low, high, epsabs=0.0, epsrel=1e-13, limit=400)[0]
    found = planck_integral(np.array(low), np.array(high))
    assert found == pytest.approx(exact, rel=1e-11)


def test_the_whole_is_pi_to_the_fourth_over_15() -> None:
    assert planck_integral(np.array(1e-9), np.array(800.0)) == pytest.approx(
        np.pi**4 / 15, rel=1e-15
    )


def test_small_arguments_give_rayleigh_and_jeans() -> None:
    low, high = np.array([1e-6, 2e-5]), np.array([3e-6, 2.1e-5])
    np.testing.assert_allclose(planck_integral(low, high), (high**3 - low**3) / 3, rtol=2e-5)


def test_the_two_series_meet() -> None:
    """Steps of one size on either side of the change at 2 and over it."""
    edge = np.array([1.999, 2.0, 2.001, 2.002]) - 1e-12
    parts = planck_integral(edge[:-1], edge[1:])
    np.testing.assert_allclose(parts[0] - parts[1], parts[1] - parts[2], atol=1e-8)
    middle = (edge[:-1] + edge[1:]) / 2
    np.testing.assert_allclose(parts, 1e-3 * middle**3 / np.expm1(middle), rtol=1e-6)


def test_parts_add_up_and_nan_stays() -> None:
    edges = np.array([0.01, 0.5, 1.9, 2.5, 7.0, 30.0, 100.0])
    parts = planck_integral(edges[:-1], edges[1:])
    whole = planck_integral(edges[:1], edges[-1:])
    assert parts.sum() == pytest.approx(whole[0], rel=1e-14)
    assert np.isnan(planck_integral(np.array(np.nan), np.array(np.nan)))
