"""Radiance within a band against quadrature, Stefan and Boltzmann, and its own inverse."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.constants import c, h, k, sigma
from scipy.integrate import quad

from thermo.errors import InputError
from thermo.imaging._band import Band
from thermo.imaging._response import signal_of, slope_of, temperature_of

LONG, MIDDLE, SHORT = Band(7.5e-6, 14e-6), Band(3e-6, 5e-6), Band(0.9e-6, 1.7e-6)
ALL = Band(1e-7, 1e-3)
bands = st.sampled_from((LONG, MIDDLE, SHORT, ALL))
kelvin = st.floats(200.0, 2000.0)


def spectral(wavelength: float, temperature: float) -> float:
    """Planck's law [W/m^2/sr/m]."""
    return 2 * h * c**2 / wavelength**5 / np.expm1(h * c / (wavelength * k * temperature))


@given(st.sampled_from((LONG, MIDDLE, SHORT)), kelvin)
def test_it_is_the_integral_of_planck_s_law(band: Band, temperature: float) -> None:
    exact = quad(
        spectral, band.shortest, band.longest, args=(temperature,), epsabs=0.0, epsrel=1e-12
    )[0]
    assert signal_of(band, temperature) == pytest.approx(exact, rel=1e-11)


@pytest.mark.parametrize("temperature", [300.0, 700.0, 2000.0])
def test_a_wide_band_holds_everything(temperature: float) -> None:
    """What is left out beyond 1 mm is 2 c k T / (3 lambda^3), by Rayleigh and Jeans."""
    whole = sigma * temperature**4 / np.pi
    beyond = 2 * c * k * temperature / 3 / 1e-3**3
    assert signal_of(ALL, temperature) == pytest.approx(whole, rel=1e-5)
    assert signal_of(ALL, temperature) + beyond == pytest.approx(whole, rel=2e-7)
    assert slope_of(ALL, temperature) == pytest.approx(4 * whole / temperature, rel=1e-5)


@given(bands, kelvin)
def test_the_inverse_is_exact_to_rounding(band: Band, temperature: float) -> None:
    assert temperature_of(band, signal_of(band, temperature)) == pytest.approx(
        temperature, rel=3e-14
    )


@given(st.floats(-6.5, -4.0), st.floats(0.001, 1.0), st.floats(150.0, 5000.0))
def test_any_band_can_be_inverted(start: float, width: float, temperature: float) -> None:
    band = Band(10.0**start, 10.0**start * (1.001 + width))
    signal = signal_of(band, temperature)
    found = temperature_of(band, signal)
    # A band a thousandth wide is the difference of two integrals that are alike in three digits.
    assert found == pytest.approx(temperature, rel=1e-9)


@given(bands, kelvin, st.floats(1e-6, 50.0))
def test_radiance_rises_with_temperature(band: Band, temperature: float, more: float) -> None:
    assert signal_of(band, temperature + more) > signal_of(band, temperature)


@given(bands, kelvin)
def test_the_slope_is_the_derivative(band: Band, temperature: float) -> None:
    step = 2e-4 * temperature
    ends = signal_of(band, np.array([temperature - step, temperature + step]))
    assert slope_of(band, temperature) == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-4)


def test_values_do_not_hang_on_their_neighbours() -> None:
    """Terms and steps are counted for the worst of an array."""
    temperatures = np.geomspace(200.0, 2000.0, 12).reshape(3, 4)
    signals = signal_of(LONG, temperatures)
    assert signals.shape == (3, 4)
    alone = np.array([float(signal_of(LONG, one)) for one in temperatures.ravel()])
    np.testing.assert_allclose(signals.ravel(), alone, rtol=1e-15)
    np.testing.assert_allclose(temperature_of(LONG, signals), temperatures, rtol=1e-14)


def test_there_is_no_temperature_without_radiance() -> None:
    found = temperature_of(MIDDLE, np.array([0.0, -1.0, np.nan, np.inf, 1.0]))
    assert np.isnan(found).tolist() == [True, True, True, True, False]
    assert np.isnan(LONG.signal(np.array([0.0, -5.0]))).all()


@pytest.mark.parametrize(
    ("shortest", "longest", "said"),
    [
        (7.5, 14.0, "7.5"),
        (7.5e-6, 14.0, "band: longest"),
        (7500e-3, 14e-6, "in metres"),
        (14e-6, 7.5e-6, "without width"),
        (10e-6, 10.001e-6, "without width"),
        (np.nan, 14e-6, "band: shortest"),
    ],
)
def test_bands_that_cannot_be_are_refused(shortest: float, longest: float, said: str) -> None:
    with pytest.raises(InputError, match=said):
        Band(shortest, longest)
