"""What lies between an object's temperature and a camera's reading: emission, air and window."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from thermo.errors import InputError
from thermo.observe import COLDEST, HOTTEST, check_number, real_array

_CELSIUS: Final = "give it in kelvin; if it is in degrees Celsius, add 273.15"
_PER_CENT: Final = "it looks like per cent: divide by 100"
_SHARE: Final = "give the share in the camera's band, as a number from 0 to 1"
_ROUNDING: Final = 1e-9


@final
class Optics(eqx.Module):
    """The object's surface, what it mirrors, the air and a window before the camera.

    Numbers or arrays whose shapes go with those of the temperatures, such as (rows, columns); all
    leaves are NumPy arrays.

    Arguments:

    - `emissivity`: of the object in the camera's band and direction, above 0 up to 1 [1]. In an
      array NaN stands where it is not known, as beside the object: such pixels have no temperature.
    - `reflected_temperature`: of the surroundings that the object mirrors, as black bodies [K].
    - `air_transmission`: of the air in the band between object and camera (window), above 0 [1].
      `air_temperature`: of that air [K].
    - `window_transmission`: of a window before the camera, above 0 [1]. `window_temperature`: of
      the window, which emits the rest [K].
    - `window_reflectance`: of the window [1]. `window_reflected_temperature`: of what it mirrors
      into the camera, often the camera itself [K].
    - `where`: what messages call them, such as the file.

    A temperature may be left out, and is NaN then, where nothing comes from it: the reflected one
    at emissivity 1, the air's at transmission 1, and so on.

    Raises `InputError` for shares outside 0 to 1 (per cent), an emissivity or transmission of 0, a
    window that passes and mirrors more than it gets, temperatures that cannot be kelvin or that are
    left out and needed, and shapes that do not go together.
    """

    emissivity: Float[np.ndarray, "..."]
    reflected_temperature: Float[np.ndarray, "..."]
    air_transmission: Float[np.ndarray, "..."]
    air_temperature: Float[np.ndarray, "..."]
    window_transmission: Float[np.ndarray, "..."]
    window_temperature: Float[np.ndarray, "..."]
    window_reflectance: Float[np.ndarray, "..."]
    window_reflected_temperature: Float[np.ndarray, "..."]

    def __init__(
        self,
        emissivity: ArrayLike,
        reflected_temperature: ArrayLike | None = None,
        *,
        air_transmission: ArrayLike = 1.0,
        air_temperature: ArrayLike | None = None,
        window_transmission: ArrayLike = 1.0,
        window_temperature: ArrayLike | None = None,
        window_reflectance: ArrayLike = 0.0,
        window_reflected_temperature: ArrayLike | None = None,
        where: str = "optics",
    ) -> None:
        self.emissivity = _share(emissivity, where, "emissivity", positive=True)
        self.air_transmission = _share(air_transmission, where, "air_transmission", positive=True)
        self.window_transmission = _share(
            window_transmission, where, "window_transmission", positive=True
        )
        self.window_reflectance = _share(
            window_reflectance, where, "window_reflectance", positive=False
        )
        _check_shapes((self.window_transmission, self.window_reflectance), where)
        window = 1.0 - self.window_transmission - self.window_reflectance
        if np.any(window < -_ROUNDING):
            raise InputError(
                "a window that passes and mirrors more than it gets", where=where,
                value=f"window_transmission + window_reflectance = {1.0 - np.min(window):g}",
                limit="at most 1", remedy="what a window neither passes nor mirrors it emits",
            )  # fmt: skip
        for key, given, weight in (
            ("reflected_temperature", reflected_temperature, 1.0 - self.emissivity),
            ("air_temperature", air_temperature, 1.0 - self.air_transmission),
            ("window_temperature", window_temperature, window),
            ("window_reflected_temperature", window_reflected_temperature, self.window_reflectance),
        ):
            values = _kelvin(given, where, key, needed=bool(np.any(np.abs(weight) > _ROUNDING)))
            setattr(self, key, values)
        _check_shapes(vars(self).values(), where)

    def shape(self) -> tuple[int, ...]:
        """The shape that all parts go together to: () where they are numbers."""
        return np.broadcast_shapes(*(part.shape for part in vars(self).values()))


def _share(value: object, where: str, key: str, *, positive: bool) -> np.ndarray:
    values = real_array(value, where=f"{where}: {key}", quantity=f"{key} [1]")
    # An emissivity alone may be unknown in places.
    partly = key == "emissivity" and values.ndim > 0
    least, most = (np.fmin, np.fmax) if partly else (np.minimum, np.maximum)
    ends = [
        float(least.reduce(values, axis=None, initial=np.nan if partly else np.inf)),
        float(most.reduce(values, axis=None, initial=np.nan if partly else -np.inf)),
    ]
    for end in ends:
        check_number(
            end, where=f"{where}: {key}", quantity=f"{key} [1]",
            above=0.0 if positive else None, least=None if positive else 0.0, most=1.0,
            remedy=_PER_CENT if 1.0 < ends[1] <= 100.0 else _SHARE,
        )  # fmt: skip
    return values


def _kelvin(value: ArrayLike | None, where: str, key: str, *, needed: bool) -> np.ndarray:
    place = f"{where}: {key}"
    if value is None:
        if needed:
            raise InputError(
                "a temperature is missing", where=place, value="none",
                limit=f"kelvin, from {COLDEST:g} to {HOTTEST:g} K",
                remedy="state it, or give a share of 1 (0 for a reflectance) to what comes from it",
            )  # fmt: skip
        return np.asarray(np.nan)
    values = real_array(value, where=place, quantity=f"{key} [K]")
    for end in (values.min(initial=np.inf), values.max(initial=-np.inf)):
        check_number(
            float(end), where=place, quantity=f"{key} [K]", least=COLDEST, most=HOTTEST,
            remedy=_CELSIUS,
        )  # fmt: skip
    return values


def _check_shapes(parts: Iterable[np.ndarray], where: str) -> None:
    shapes = [part.shape for part in parts]
    if together(*shapes) is None:
        raise InputError(
            "shapes that do not go together", where=where,
            value=", ".join(str(shape) for shape in shapes if shape),
            limit="numbers, or arrays of one shape such as (rows, columns)",
            remedy="give a number, or a value a pixel",
        )  # fmt: skip


def together(*shapes: tuple[int, ...]) -> tuple[int, ...] | None:
    """The shape that arrays of these shapes broadcast to; None where they do not go together."""
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        return None
