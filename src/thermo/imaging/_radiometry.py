"""The measurement equation: from an object's temperature to a camera's reading, and back."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from thermo.errors import InputError
from thermo.observe import real_array

from ._optics import Optics, together
from ._response import AbstractResponse, as_kelvin


def measured_signal(
    response: AbstractResponse, optics: Optics, temperature: ArrayLike
) -> Float[np.ndarray, "..."]:
    """What a camera measures of an object at `temperature` [K], in the response's own unit.

    S = t_w t_a (e S(T) + (1 - e) S(T_r)) + t_w (1 - t_a) S(T_a)
        + (1 - t_w - r_w) S(T_w) + r_w S(T_wr)

    with emissivity e and reflected temperature T_r, transmission t_a and temperature T_a of the
    air, and transmission t_w, reflectance r_w, temperature T_w and reflected temperature T_wr of a
    window before the camera. The object is opaque and the surroundings are black.

    Arguments: `temperature`, a number or an array whose shape goes with that of `optics`, such as
    (frames, rows, columns).

    Raises `InputError` for temperatures that cannot be kelvin and shapes that do not go together.

    Source: FLIR i5 user's manual, publ. T559382 (2009), p. 147, "The measurement formula", with the
    window added; Minkina and Dudzik, Infrared Thermography: Errors and Uncertainties (2009).
    """
    kelvin = as_kelvin(temperature, where="temperature")
    _check_shape(optics, kelvin, "temperature")
    gain, rest = gain_and_rest(response, optics)
    return np.asarray(gain * response.signal(kelvin) + rest)


def temperature_from_signal(
    response: AbstractResponse, optics: Optics, signal: ArrayLike
) -> Float[np.ndarray, "..."]:
    """The object's temperature [K] from what a camera measures, the inverse of `measured_signal`.

    Arguments: `signal`, in the response's own unit, a number or an array whose shape goes with that
    of `optics`. The result is NaN where no temperature gives the signal, as below what is reflected
    alone.

    Raises `InputError` for shapes that do not go together.
    """
    values = real_array(signal, where="signal", quantity="signal")
    _check_shape(optics, values, "signal")
    gain, rest = gain_and_rest(response, optics)
    return response.temperature(np.asarray((values - rest) / gain))


def apparent_temperature(
    response: AbstractResponse, optics: Optics, temperature: ArrayLike
) -> Float[np.ndarray, "..."]:
    """What a camera that is set to emissivity 1 and no air or window reads [K].

    Arguments and errors are those of `measured_signal`.
    """
    return response.temperature(measured_signal(response, optics, temperature))


def true_temperature(
    response: AbstractResponse, optics: Optics, apparent: ArrayLike
) -> Float[np.ndarray, "..."]:
    """The object's temperature [K] from an apparent one, the inverse of `apparent_temperature`.

    Arguments: `apparent`, what a camera set to emissivity 1 and transmission 1 reads [K]; a number
    or an array whose shape goes with that of `optics`. The result is NaN where no temperature gives
    the reading.

    Raises `InputError` for readings that cannot be kelvin and shapes that do not go together.
    """
    kelvin = as_kelvin(apparent, where="apparent temperature")
    return temperature_from_signal(response, optics, response.signal(kelvin))


def gain_and_rest(
    response: AbstractResponse, optics: Optics
) -> tuple[Float[np.ndarray, "..."], Float[np.ndarray, "..."]]:
    """What S(T) of the object is multiplied by [1], and what is added, in the response's unit."""
    passed = optics.window_transmission * optics.air_transmission
    air = optics.window_transmission * (1.0 - optics.air_transmission)
    window = 1.0 - optics.window_transmission - optics.window_reflectance
    rest = (
        share_of(response, passed * (1.0 - optics.emissivity), optics.reflected_temperature)
        + share_of(response, air, optics.air_temperature)
        + share_of(response, window, optics.window_temperature)
        + share_of(response, optics.window_reflectance, optics.window_reflected_temperature)
    )
    return np.asarray(passed * optics.emissivity), np.asarray(rest)


def share_of(
    response: AbstractResponse, weight: ArrayLike, kelvin: Float[np.ndarray, "..."]
) -> Float[np.ndarray, "..."]:
    """A weight [1] times S(T), T in [K]; nothing comes from a temperature that was left out."""
    share = np.asarray(weight)
    return np.where(np.isnan(kelvin), 0.0 * share, share * response.signal(kelvin))


def _check_shape(optics: Optics, values: np.ndarray, where: str) -> None:
    if together(optics.shape(), values.shape) is None:
        raise InputError(
            "optics and readings have shapes that do not go together", where=where,
            value=f"shape {values.shape}, optics of shape {optics.shape()}",
            limit="one shape, or numbers in the optics",
            remedy="give the emissivity a value a pixel, (rows, columns), or one number",
        )  # fmt: skip
