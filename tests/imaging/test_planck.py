"""Makers' Planck constants against closed forms, Planck's law and their own inverse."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.constants import c, h, k

from thermo.errors import InputError
from thermo.imaging._band import Band
from thermo.imaging._planck import PlanckConstants
from thermo.imaging._response import signal_of, slope_of, temperature_of

CAMERA = PlanckConstants(21106.77, 0.012545258, 1501.0, 1.0, -7340.0)
kelvin = st.floats(200.0, 2000.0)


def test_closed_forms() -> None:
    """exp(B/T) is 2 at B / ln 2, and Wien's law is a bare exponential."""
    planck = PlanckConstants(5000.0, 2.0, 1400.0, 1.0, 300.0)
    assert signal_of(planck, 1400.0 / np.log(2.0)) == pytest.approx(2500.0 - 300.0, rel=1e-12)
    assert slope_of(planck, 1400.0 / np.log(2.0)) == pytest.approx(
        2500.0 * 1400.0 * 2.0 / (1400.0 / np.log(2.0)) ** 2, rel=1e-12
    )
    wien = PlanckConstants(1e5, 1.0, 1000.0, 0.0, 0.0)
    assert signal_of(wien, 500.0) == pytest.approx(1e5 * np.exp(-2.0), rel=1e-12)
    assert temperature_of(wien, 1e5 * np.exp(-4.0)) == pytest.approx(250.0, rel=1e-12)


def test_planck_s_law_in_a_narrow_band_is_the_same() -> None:
    """At one wavelength B is h c / (lambda k), and R1 / R2 drops out of ratios."""
    wavelength = 10e-6
    narrow = Band(wavelength * 0.9994, wavelength * 1.0006)
    constants = PlanckConstants(1.0, 1.0, h * c / (wavelength * k), 1.0, 0.0)
    temperatures = np.array([220.0, 300.0, 900.0, 2000.0])
    ratio = signal_of(narrow, temperatures) / signal_of(constants, temperatures)
    np.testing.assert_allclose(ratio, ratio[0], rtol=3e-6)


@given(kelvin, st.floats(0.5, 1.5), st.floats(1300.0, 1600.0), st.floats(-1e4, 1e4))
def test_each_is_the_inverse_of_the_other(
    temperature: float, f: float, b: float, offset: float
) -> None:
    planck = PlanckConstants(21106.77, 0.0125, b, f, offset)
    signal = signal_of(planck, temperature)
    if np.isnan(signal):
        assert f > 1 and temperature >= b / np.log(f) * (1 - 1e-12)
        return
    assert temperature_of(planck, signal) == pytest.approx(temperature, rel=1e-9)


@given(kelvin, st.floats(1e-3, 100.0))
def test_signals_rise_with_temperature(temperature: float, more: float) -> None:
    assert signal_of(CAMERA, temperature + more) > signal_of(CAMERA, temperature)


@given(kelvin)
def test_the_slope_is_the_derivative(temperature: float) -> None:
    step = 1e-3 * temperature
    ends = signal_of(CAMERA, np.array([temperature - step, temperature + step]))
    slope = (ends[1] - ends[0]) / (2 * step)
    assert slope_of(CAMERA, temperature) == pytest.approx(slope, rel=1e-4)


def test_there_is_no_temperature_where_no_signal_comes_from() -> None:
    signals = np.array([7340.0, 7000.0, np.nan, np.inf, 7341.0])
    found = temperature_of(CAMERA, signals)
    assert np.isnan(found).tolist() == [True, True, True, True, False]
    weak = PlanckConstants(1e4, 1.0, 1400.0, 0.5, 0.0)
    assert np.isnan(temperature_of(weak, 2e4))
    assert np.isfinite(temperature_of(weak, 1.99e4))
    folded = PlanckConstants(1e4, 1.0, 1400.0, 2.0, 0.0)
    assert np.isnan(signal_of(folded, np.array([2019.0, 2020.0]))).tolist() == [False, True]
    assert np.isnan(slope_of(folded, 2500.0))


def test_shapes_are_kept() -> None:
    temperatures = np.full((2, 3, 4), 300.0)
    assert signal_of(CAMERA, temperatures).shape == (2, 3, 4)
    assert temperature_of(CAMERA, 16000).shape == ()
    assert temperature_of(CAMERA, np.zeros((0, 3))).shape == (0, 3)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("r1", 0.0),
        ("r1", np.nan),
        ("r2", -1.0),
        ("b", 0.0),
        ("f", -0.1),
        ("f", 1501.0),
        ("o", np.inf),
    ],
)
def test_constants_that_cannot_be_are_refused(key: str, value: float) -> None:
    numbers = {"r1": 2e4, "r2": 0.0125, "b": 1501.0, "f": 1.0, "o": -7340.0} | {key: value}
    with pytest.raises(InputError, match=f"ir.jpg: {key}"):
        PlanckConstants(**numbers, where="ir.jpg")


def test_celsius_is_refused() -> None:
    with pytest.raises(InputError, match="Celsius"):
        signal_of(CAMERA, 25.0)
    with pytest.raises(InputError, match="plain numbers"):
        temperature_of(CAMERA, "16000")
