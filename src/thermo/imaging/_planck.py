"""The constants that makers of cameras give in place of Planck's law over a band."""

from __future__ import annotations

from typing import final

import numpy as np
from jaxtyping import Float

from thermo.observe import check_number

from ._response import AbstractResponse


@final
class PlanckConstants(AbstractResponse):
    """Counts of a sensor by Planck's law at one wavelength, fitted by the camera's maker.

    S(T) = R1 / (R2 (exp(B / T) - F)) - O

    Arguments, as metadata of radiometric pictures name them (Planck R1, R2, B, F, O):

    - `r1`: the sensor's gain, in counts. `r2`: a factor of the measuring range [1].
    - `b`: h c / (lambda k) of an effective wavelength [K], 1400 K to 1500 K for 10 um.
    - `f`: 1 for Planck's law, 0 for Wien's [1]; fits differ a little from 1.
    - `o`: what is taken off, in counts; often negative.

    Raises `InputError` for numbers that are not finite, r1, r2 or b not above 0, and f outside 0 to
    2, where no calibration near Planck's law is, only numbers in another order.

    Source: FLIR's equation, as described by Tattersall, Thermimage (2021), `raw2temp`,
    doi:10.5281/zenodo.1069704.
    """

    r1: float
    r2: float
    b: float
    f: float
    o: float

    def __init__(
        self, r1: float, r2: float, b: float, f: float, o: float, *, where: str = "Planck constants"
    ) -> None:
        self.r1 = check_number(r1, where=f"{where}: r1", quantity="R1 [1]", above=0.0)
        self.r2 = check_number(r2, where=f"{where}: r2", quantity="R2 [1]", above=0.0)
        self.b = check_number(b, where=f"{where}: b", quantity="B [K]", above=0.0)
        self.f = check_number(f, where=f"{where}: f", quantity="F [1]", least=0.0, most=2.0)
        self.o = check_number(o, where=f"{where}: o", quantity="O [1]")

    def signal(self, temperature: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
        """Counts [1] of a black body of `temperature` [K].

        NaN at or below 0 K and, where F is above 1, from the pole B / ln F on.
        """
        with np.errstate(all="ignore"):
            under = self.r2 * (np.expm1(self.b / temperature) + (1.0 - self.f))
            counts = self.r1 / under - self.o
        return np.where((temperature > 0) & (under > 0), counts, np.nan)

    def temperature(self, signal: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
        """T = B / ln(R1 / (R2 (S + O)) + F) [K] of counts [1].

        NaN at or below -O counts and, where F is below 1, from R1 / (R2 (1 - F)) - O on.
        """
        with np.errstate(all="ignore"):
            power = np.log1p(self.r1 / (self.r2 * (signal + self.o)) + (self.f - 1.0))
            kelvin = self.b / power
        return np.where((signal + self.o > 0) & (power > 0) & np.isfinite(kelvin), kelvin, np.nan)

    def slope(self, temperature: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
        """dS/dT = R1 B exp(B/T) / (R2 T^2 (exp(B/T) - F)^2) [1/K] at temperatures [K]."""
        with np.errstate(all="ignore"):
            down = np.exp(-self.b / temperature)
            under = self.r2 * temperature**2 * (1.0 - self.f * down) ** 2
            slope = self.r1 * self.b * down / under
        return np.where((temperature > 0) & (self.f * down < 1), slope, np.nan)
