"""How far a true temperature may be off, part by part, to first order."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from thermo.errors import InputError
from thermo.observe import check_number

from ._optics import Optics
from ._radiometry import apparent_temperature, gain_and_rest, share_of
from ._response import AbstractResponse, as_kelvin

_NOISE: Final = ("signal", "apparent")


@final
class Deviations(eqx.Module):
    """Standard deviations of what a true temperature is made of; 0 is known exactly.

    Noise, anew in each pixel and frame:

    - `signal`: of the signal, in the response's own unit; for a camera whose noise (NETD) is stated
      at 30 C, that times `slope_of(response, 303.15)`.
    - `apparent`: of the apparent temperature as it is read [K].

    In common, the same in all pixels and frames, so that no mean over them makes it smaller:

    - `calibration`: of apparent temperatures [K]; a maker's accuracy of 2 K, taken as bounds of
      equal chance, is 2 K / sqrt(3).
    - the others: of the argument of `Optics` of that name, [1] or [K].

    Raises `InputError` for numbers below 0, and above 1 for shares (per cent).
    """

    signal: float = 0.0
    apparent: float = 0.0
    calibration: float = 0.0
    emissivity: float = 0.0
    reflected_temperature: float = 0.0
    air_transmission: float = 0.0
    air_temperature: float = 0.0
    window_transmission: float = 0.0
    window_temperature: float = 0.0
    window_reflectance: float = 0.0
    window_reflected_temperature: float = 0.0

    def __check_init__(self) -> None:
        for key, value in vars(self).items():
            share = key.endswith(("emissivity", "transmission", "reflectance"))
            check_number(
                value, where=f"deviations: {key}", quantity=f"standard deviation of {key}",
                least=0.0, most=1.0 if share else None,
                remedy="give shares as numbers from 0 to 1, not in per cent" if share
                else "give a standard deviation, 0 for what is known",
            )  # fmt: skip


@final
class ErrorBudget(eqx.Module):
    """Standard deviations of a true temperature, each part by itself [K].

    - `noise`: `signal` and `apparent`, which change from pixel to pixel and frame to frame.
    - `common`: the others by their names in `Deviations`, the same in all pixels and frames.

    Parts add in squares: the inputs are taken as independent.
    """

    noise: dict[str, Float[np.ndarray, "..."]]
    common: dict[str, Float[np.ndarray, "..."]]

    def of_noise(self) -> Float[np.ndarray, "..."]:
        """Of all noise [K]."""
        return _in_squares(self.noise)

    def in_common(self) -> Float[np.ndarray, "..."]:
        """Of what all pixels and frames have in common [K]."""
        return _in_squares(self.common)

    def total(self) -> Float[np.ndarray, "..."]:
        """Of all parts of a single reading [K]."""
        return np.asarray(np.hypot(self.of_noise(), self.in_common()))

    def largest(self) -> str:
        """The name of the part with the largest mean square."""
        parts = self.noise | self.common
        return max(parts, key=lambda name: float(np.nanmean(parts[name] ** 2)))


def sensitivities(
    response: AbstractResponse, optics: Optics, temperature: ArrayLike
) -> dict[str, Float[np.ndarray, "..."]]:
    """What a true temperature changes by with each of its inputs, the reading held.

    dT/dp = -(dS/dp) / (t_w t_a e S'(T)), S being `measured_signal`, with the sign that it has;
    for the reading itself 1 / (t_w t_a e S'(T)), for an apparent temperature that times S' there.

    Arguments: `temperature`, the true one [K], a number or an array. Returns arrays by the names in
    `Deviations`, in kelvin for each unit of the input: [K] for shares, [1] for temperatures. They
    are NaN for what comes from a temperature that `optics` leaves out.

    Raises `InputError` as `measured_signal` does.

    Source: JCGM 100:2008 (GUM), section 5.1.
    """
    kelvin = as_kelvin(temperature, where="temperature")
    apparent = apparent_temperature(response, optics, kelvin)
    gain, _ = gain_and_rest(response, optics)
    passed = optics.window_transmission * optics.air_transmission
    own, around = response.signal(kelvin), response.signal(optics.reflected_temperature)
    air = response.signal(optics.air_temperature)
    window = response.signal(optics.window_temperature)
    mirrored = response.signal(optics.window_reflected_temperature)
    dull, thick = 1.0 - optics.emissivity, 1.0 - optics.air_transmission
    left = optics.emissivity * own + share_of(response, dull, optics.reflected_temperature)
    before = optics.air_transmission * left + share_of(response, thick, optics.air_temperature)
    to_window = optics.window_transmission
    emits = 1.0 - to_window - optics.window_reflectance
    mirrors = optics.window_reflectance
    slopes = {
        "emissivity": passed * (own - around),
        "reflected_temperature": passed * dull * response.slope(optics.reflected_temperature),
        "air_transmission": to_window * (left - air),
        "air_temperature": to_window * thick * response.slope(optics.air_temperature),
        "window_transmission": before - window,
        "window_temperature": emits * response.slope(optics.window_temperature),
        "window_reflectance": mirrored - window,
        "window_reflected_temperature": mirrors
        * response.slope(optics.window_reflected_temperature),
    }
    by_signal = 1.0 / (gain * response.slope(kelvin))
    reading = np.asarray(response.slope(apparent) * by_signal)
    found = {"signal": np.asarray(by_signal), "apparent": reading, "calibration": reading}
    return found | {name: np.asarray(-slope * by_signal) for name, slope in slopes.items()}


def uncertainty(
    response: AbstractResponse, optics: Optics, temperature: ArrayLike, deviations: Deviations
) -> ErrorBudget:
    """Standard deviations [K] of true temperatures, to first order, each part by itself.

    Arguments: `temperature`, the true one [K], a number or an array of any shape.

    First order is enough where the deviation of the emissivity is small against the emissivity:
    for 0.05 of 0.2 the one side is a quarter more, the other a sixth less.

    Raises `InputError` as `measured_signal` does, and where a deviation is given for what `optics`
    leaves out.

    Source: JCGM 100:2008 (GUM), equation (10).
    """
    each = sensitivities(response, optics, temperature)
    missing = bool(np.isnan(each["signal"]).all())
    parts = {name: _part(deviations, name, slope, missing) for name, slope in each.items()}
    shape = np.broadcast_shapes(*(part.shape for part in parts.values()))
    full = {name: np.broadcast_to(part, shape).copy() for name, part in parts.items()}
    return ErrorBudget(
        noise={name: full[name] for name in _NOISE},
        common={name: part for name, part in full.items() if name not in _NOISE},
    )


def _part(deviations: Deviations, name: str, slope: np.ndarray, missing: bool) -> np.ndarray:
    deviation = getattr(deviations, name)
    if deviation == 0.0:
        return np.zeros(())
    if np.isnan(slope).all() and not missing:
        raise InputError(
            "no temperature to go with this deviation", where=f"deviations: {name}",
            value=deviation, limit="0, or optics that state reflected_temperature, "
            "air_temperature, window_temperature and window_reflected_temperature as needed",
            remedy="state in the optics the temperature of what this share comes from",
        )  # fmt: skip
    return np.asarray(np.abs(slope) * deviation)


def _in_squares(parts: Mapping[str, np.ndarray]) -> np.ndarray:
    return np.asarray(np.sqrt(sum(part**2 for part in parts.values())))
