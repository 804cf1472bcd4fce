"""From temperatures to colours."""

from __future__ import annotations

from typing import Final, final

import equinox as eqx
import matplotlib as mpl
import numpy as np
from jaxtyping import Float, UInt8

from thermo.errors import InputError
from thermo.observe import check_number

COLOUR_MAPS: Final = (
    "inferno", "magma", "plasma", "viridis", "cividis", "hot", "gray", "coolwarm", "turbo", "jet",
)  # fmt: skip
"""Names of the colour maps that may be chosen; the first five are even to the eye."""

_ENTRIES: Final = 256


@final
class Colours(eqx.Module):
    """How temperatures are shown; the leaves are NumPy arrays.

    Arguments:

    - `lowest`, `highest`: T_min and T_max [K]; what is colder or hotter gets the colour of the end.
    - `name`: of the colour map, one of `COLOUR_MAPS`.
    - `background`: red, green and blue, 0 to 255, of pixels without a temperature.

    Raises `InputError` for a range that is empty, an unknown name and a colour that is none.

    Source: paper, appendix A.1 (checklist F10).
    """

    lowest: float = eqx.field(static=True)
    highest: float = eqx.field(static=True)
    table: UInt8[np.ndarray, "entries 3"]
    background: UInt8[np.ndarray, "3"]

    def __init__(
        self,
        lowest: float,
        highest: float,
        *,
        name: str = "inferno",
        background: tuple[int, int, int] = (255, 255, 255),
    ) -> None:
        self.lowest = check_number(lowest, where="lowest", quantity="temperature [K]")
        self.highest = check_number(
            highest, where="highest", quantity="temperature [K]", above=self.lowest,
            remedy="give the range of the temperatures, the lower end first",
        )  # fmt: skip
        if name not in COLOUR_MAPS:
            raise InputError(
                "there is no such colour map", where="name", value=name,
                limit=", ".join(COLOUR_MAPS), remedy="choose one of these names",
            )  # fmt: skip
        if len(background) != 3 or not all(
            isinstance(one, int | np.integer) and 0 <= one <= 255 for one in background
        ):
            raise InputError(
                "this is no colour", where="background", value=background,
                limit="three whole numbers from 0 to 255: red, green, blue",
                remedy="give for example (255, 255, 255) for white",
            )  # fmt: skip
        middles = (np.arange(_ENTRIES) + 0.5) / _ENTRIES
        self.table = mpl.colormaps[name](middles, bytes=True)[:, :3].astype(np.uint8)
        self.background = np.array(background, np.uint8)


def normalised(
    values: Float[np.ndarray, "*shape"], lowest: float, highest: float
) -> Float[np.ndarray, "*shape"]:
    """clip((T - T_min) / (T_max - T_min), 0, 1) of temperatures [K]; NaN stays NaN.

    Source: paper, appendix A.1, "Thermal Infrared Video Rendering" (checklist F10).
    """
    # Subtracted first, in place after that: a film's every frame passes here.
    share = values - lowest
    share *= 1.0 / (highest - lowest)
    return np.clip(share, 0.0, 1.0, out=share)


def coloured(
    picture: Float[np.ndarray, "rows columns"], colours: Colours
) -> UInt8[np.ndarray, "rows columns 3"]:
    """Red, green and blue of a picture of temperatures [K]; the background where it is NaN.

    Source: paper, appendix A.1, "Thermal Infrared Video Rendering" (checklist F10).
    """
    entries = len(colours.table)
    share = normalised(picture, colours.lowest, colours.highest)
    share *= entries
    np.minimum(share, entries - 1, out=share)
    share[np.isnan(share)] = entries
    table = np.concatenate([colours.table, colours.background[None]])
    return np.take(table, share.astype(np.intp), axis=0)
