"""What a camera's signal is as a function of the temperature of a black body."""

from __future__ import annotations

from abc import abstractmethod

import equinox as eqx
import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from thermo.observe import check_kelvin, real_array


class AbstractResponse(eqx.Module):
    """The signal S(T) of a black body: rising with its temperature, and its own inverse.

    Only differences and ratios of signals enter what is made of them, so that a response may be in
    a sensor's counts or in W/m2/sr.
    """

    @abstractmethod
    def signal(self, temperature: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
        """S(T) in the response's own unit for temperatures [K]; NaN where there is none."""

    @abstractmethod
    def temperature(self, signal: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
        """The temperature [K] of a signal; NaN where no temperature gives it."""

    @abstractmethod
    def slope(self, temperature: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
        """dS/dT, in the response's own unit a kelvin, at temperatures [K]."""


def signal_of(response: AbstractResponse, temperature: ArrayLike) -> Float[np.ndarray, "..."]:
    """The signal S(T) of a black body, in the response's own unit.

    Arguments: `temperature` [K], a number or an array of any shape; NaN stays NaN.

    Raises `InputError` for temperatures that cannot be kelvin.
    """
    return response.signal(as_kelvin(temperature, where="temperature"))


def temperature_of(response: AbstractResponse, signal: ArrayLike) -> Float[np.ndarray, "..."]:
    """The temperature [K] of the black body that gives a signal, the inverse of `signal_of`.

    Arguments: `signal`, in the response's own unit, a number or an array of any shape. The result
    is NaN where no temperature gives the signal.

    Raises `InputError` where `signal` holds no plain numbers.
    """
    return response.temperature(real_array(signal, where="signal", quantity="signal"))


def slope_of(response: AbstractResponse, temperature: ArrayLike) -> Float[np.ndarray, "..."]:
    """dS/dT of a black body, in the response's own unit a kelvin, at temperatures [K].

    Noise of 0.05 K at 303 K is one of 0.05 * slope_of(response, 303.0) of the signal.

    Raises `InputError` for temperatures that cannot be kelvin.
    """
    return response.slope(as_kelvin(temperature, where="temperature"))


def as_kelvin(temperature: object, *, where: str) -> Float[np.ndarray, "..."]:
    """Temperatures [K] as float64, or `InputError` naming `where`; NaN is a missing value."""
    values = real_array(temperature, where=where, quantity="temperature [K]")
    check_kelvin(np.atleast_1d(values), where=where)
    return values
