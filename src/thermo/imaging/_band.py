"""Radiance of a black body within a band of wavelengths."""

from __future__ import annotations

from typing import Final, final

import numpy as np
from jaxtyping import Float
from scipy.constants import c, h, k

from thermo.errors import InputError
from thermo.observe import check_number

from ._planck_integral import planck_integral
from ._response import AbstractResponse

_FIRST: Final = 2.0 * k**4 / (h**3 * c**2)
"""What T^4 times the integral is multiplied by [W/m^2/sr/K^4]."""

_SECOND: Final = h * c / k
"""The second constant of radiation [m K]."""

_CLOSE: Final = 1e-8
"""A step in 1/T, over 1/T, after which the error is its square and Newton's method ends [1]."""

_STEPS: Final = 100
"""Newton's steps at the most; ten are usual [1]."""

_METRES: Final = "give wavelengths in metres, 8 um to 14 um as 8e-6 and 14e-6"


@final
class Band(AbstractResponse):
    """The band of wavelengths that a camera sees, with the same response all over it.

    L(T) = integral over the band of 2 h c^2 / (lambda^5 (exp(h c / (lambda k T)) - 1))

    in W/m^2/sr, as the difference of two values of the fractional function.

    Arguments: `shortest` and `longest` wavelength [m], such as 8e-6 and 14e-6. A camera whose
    response is not known otherwise is described by the band that its data sheet states.

    Raises `InputError` for wavelengths outside 0.1 um to 1 mm, as in micrometres, and where the
    band is empty or narrower than a thousandth of its wavelength, where digits are lost.

    Source: Planck's law; `planck_integral` for the series.
    """

    shortest: float
    longest: float

    def __init__(self, shortest: float, longest: float, *, where: str = "band") -> None:
        for key, value in (("shortest", shortest), ("longest", longest)):
            check_number(
                value, where=f"{where}: {key}", quantity="wavelength [m]", least=1e-7, most=1e-3,
                remedy=_METRES,
            )  # fmt: skip
        if not longest >= 1.001 * shortest:
            raise InputError(
                "a band without width", where=where, value=f"{shortest:g} m to {longest:g} m",
                limit="a longest wavelength at least a thousandth above the shortest",
                remedy="give the shortest first, and a filter's width at half of its height",
            )  # fmt: skip
        self.shortest, self.longest = float(shortest), float(longest)

    def signal(self, temperature: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
        """Radiance [W/m^2/sr] of a black body of `temperature` [K]; NaN at or below 0 K."""
        return self._radiance_and_slope(temperature)[0]

    def slope(self, temperature: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
        """dL/dT [W/m^2/sr/K] at `temperature` [K]."""
        return self._radiance_and_slope(temperature)[1]

    def temperature(self, signal: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
        """The temperature [K] of a radiance [W/m^2/sr]; NaN where that is not above 0.

        Newton's method for ln L as a function of 1/T. That function is convex, being a sum of
        such, so that from a temperature above the solution all steps lead down and none goes too
        far. It starts at (L + b) / a, which is one: t^3 / (exp(t) - 1) > t^2 - t^3 / 2 makes
        L > a T - b.
        """
        inner, outer = _SECOND / self.longest, _SECOND / self.shortest
        a = _FIRST * (outer**3 - inner**3) / 3.0
        b = _FIRST * (outer**4 - inner**4) / 8.0
        with np.errstate(all="ignore"):
            wanted = np.where((signal > 0) & np.isfinite(signal), signal, np.nan)
            kelvin = np.asarray((wanted + b) / a)
            for _ in range(_STEPS):
                radiance, slope = self._radiance_and_slope(kelvin)
                step = np.log(radiance / wanted) * radiance / (kelvin * slope)
                kelvin = np.asarray(kelvin / (1.0 + step))
                if not np.fmax.reduce(np.abs(step), axis=None, initial=0.0) > _CLOSE:
                    break
        return kelvin

    def _radiance_and_slope(self, temperature: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """d/dT T^4 I(x) = T^3 (4 I(x) + x^4 / (exp(x) - 1)), I being the integral from x on."""
        with np.errstate(all="ignore"):
            kelvin = np.where(temperature > 0, temperature, np.nan)
            low, high = _SECOND / (self.longest * kelvin), _SECOND / (self.shortest * kelvin)
            part = planck_integral(np.asarray(low), np.asarray(high))
            cube = _FIRST * kelvin**3
            ends = low**4 / np.expm1(low) - high**4 / np.expm1(high)
            return np.asarray(cube * kelvin * part), np.asarray(cube * (4.0 * part + ends))
