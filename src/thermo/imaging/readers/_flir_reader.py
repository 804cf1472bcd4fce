"""Radiometric JPEG of FLIR cameras, one or a folder of them."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Final, final

import numpy as np

from thermo.errors import InputError
from thermo.imaging._frames import Frames
from thermo.imaging._optics import Optics
from thermo.imaging._planck import PlanckConstants
from thermo.imaging._radiometry import temperature_from_signal

from ._damaged import damaged
from ._flir_file import FlirPicture, FlirSettings, flir_picture
from ._jpeg import is_jpeg, is_of_dji, jpeg_frames
from ._reader import AbstractReader
from ._stated import Stated

_POSITIVE: Final = ("planck_r1", "planck_r2", "planck_b")
_SHARES: Final = ("emissivity", "window_transmission")


@final
class FlirReader(AbstractReader):
    """Radiometric JPEG of FLIR: temperatures [K] by the settings in each file.

    Emissivity, reflected temperature, distance, air and window are those that the file holds, and
    the camera's Planck constants turn the signal into kelvin; temperatures beyond those that the
    file says the camera tells are missing, NaN. Stating `unit` = "counts" gives the signal itself
    [1]. Times are the dates in the files; where those are whole seconds that repeat, state `rate`.
    """

    def format(self) -> str:
        """The files that it reads."""
        return "radiometric JPEG of FLIR (one, or a folder of them)"

    def recognises(self, path: Path) -> bool:
        """By suffix, or by the first bytes of a JPEG, unless it is of DJI's own format."""
        return is_jpeg(path) and not is_of_dji(path)

    def read(self, path: Path, given: Stated) -> Frames:
        """The frames [K] or [1] and their times [s]; raises `InputError`."""
        unit = "counts" if given.unit == "counts" else "K"
        return jpeg_frames(
            path, lambda file, content: _values(file, content, unit), given, unit=unit
        )  # fmt: skip


def _values(path: Path, content: bytes, unit: str) -> np.ndarray:
    picture = _picture(path, content)
    if unit == "counts":
        return picture.signal
    known = picture.settings
    passed = _air(known)
    _check_settings(path, known, passed)
    response = PlanckConstants(
        known.planck_r1, known.planck_r2, known.planck_b, known.planck_f, known.planck_o,
        where=str(path),
    )  # fmt: skip
    optics = Optics(
        known.emissivity,
        known.reflected_temperature if known.emissivity < 1 else None,
        air_transmission=passed,
        air_temperature=known.air_temperature if passed < 1 else None,
        window_transmission=known.window_transmission,
        window_temperature=known.window_temperature if known.window_transmission < 1 else None,
        where=str(path),
    )
    kelvin = temperature_from_signal(response, optics, picture.signal.astype(float))
    if known.coldest < known.warmest:
        kelvin[(kelvin < known.coldest) | (kelvin > known.warmest)] = np.nan
    return kelvin.astype(np.float32)


def _picture(path: Path, content: bytes) -> FlirPicture:
    from PIL import Image

    try:
        found = flir_picture(content)
        with Image.open(io.BytesIO(content)) as picture:
            picture.load()  # the temperatures stand in front of the picture: is the rest there?
    except Exception as error:  # Pillow lets out whatever its parsing meets
        raise damaged(path, "radiometric JPEG of FLIR", error) from error
    if found is None:
        raise InputError(
            "no radiometric header", where=str(path), value="a JPEG without data of a FLIR camera",
            limit="a radiometric JPEG as the camera stored it",
            remedy="copy it from the camera unchanged: programs that edit or send pictures drop "
            "its temperatures; take photographs out of the folder",
        )  # fmt: skip
    return found


def _air(known: FlirSettings) -> float:
    """What the air passes on [1], by the camera's own coefficients.

    t_a = x exp(-sqrt(d) (a_1 + b_1 sqrt(w))) + (1 - x) exp(-sqrt(d) (a_2 + b_2 sqrt(w)))

    with the distance d [m] and the water w [g/m3] in air of t [C] and relative humidity h,
    w = h exp(1.5587 + 0.06939 t - 2.7816e-4 t^2 + 6.8455e-7 t^3).

    Source: Minkina and Dudzik, Infrared Thermography: Errors and Uncertainties (2009). Some
    programs take the root of half the distance on either side of a window, and are off from FLIR
    Tools by tenths of a kelvin at some metres.
    """
    celsius = known.air_temperature - 273.15
    with np.errstate(all="ignore"):  # settings that make no sense are refused by what comes out
        water = known.humidity * np.exp(
            np.polynomial.polynomial.polyval(celsius, (1.5587, 0.06939, -2.7816e-4, 6.8455e-7))
        )
        far, wet = np.sqrt([max(known.distance, 0.0), max(water, 0.0)])
        first = np.exp(-far * (known.alpha_1 + known.beta_1 * wet))
        second = np.exp(-far * (known.alpha_2 + known.beta_2 * wet))
        return float(np.minimum(known.mixture * first + (1 - known.mixture) * second, 1.0))


def _check_settings(path: Path, known: FlirSettings, passed: float) -> None:
    positive = {name: getattr(known, name) for name in _POSITIVE}
    shares = {name: getattr(known, name) for name in _SHARES} | {"transmission of the air": passed}
    wrong = [name for name, value in positive.items() if not value > 0]
    wrong += [name for name, value in shares.items() if not 0 < value <= 1]
    if wrong:
        raise InputError(
            "the radiometric header is wrong", where=str(path),
            value=f"{wrong[0]} = {(positive | shares)[wrong[0]]:g}",
            limit="positive constants of Planck's law, shares above 0 and at most 1",
            remedy="copy the file from the camera again; or state recording.unit=counts and "
            "calibrate the signal by a radiometry of your own",
        )  # fmt: skip
