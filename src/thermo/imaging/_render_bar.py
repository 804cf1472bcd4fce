"""A colour bar with its numbers, drawn beside a picture."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Final, final

import matplotlib as mpl
import numpy as np
from jaxtyping import UInt8
from matplotlib.ticker import MaxNLocator
from PIL import Image, ImageDraw, ImageFont

from thermo.errors import InputError

from ._colours import Colours

_LEAST_ROWS: Final = 48
_ZERO_CELSIUS: Final = 273.15


@final
class Degrees(Enum):
    """What a colour bar counts in: `KELVIN`, or degrees `CELSIUS`."""

    KELVIN = "K"
    CELSIUS = "°C"


def colour_bar(
    rows: int, colours: Colours, degrees: Degrees = Degrees.KELVIN
) -> UInt8[np.ndarray, "rows bar 3"]:
    """A colour bar as high as a picture of so many `rows` [px], to be set at its right.

    From `colours.highest` [K] above to `colours.lowest` below, with marks at round numbers; the
    unit stands above it. Dark on a light background, light on a dark one.

    Raises `InputError` for pictures of fewer than 48 rows, which hold no two numbers.
    """
    if rows < _LEAST_ROWS:
        raise InputError(
            "there is no room for a colour bar", where="rows", value=rows,
            limit=f"at least {_LEAST_ROWS} rows", remedy="render larger pictures, or leave it out",
        )  # fmt: skip
    size = int(np.clip(rows / 22, 10, 28))
    font = ImageFont.truetype(Path(mpl.get_data_path(), "fonts", "ttf", "DejaVuSans.ttf"), size)
    zero = _ZERO_CELSIUS if degrees is Degrees.CELSIUS else 0.0
    marks = _round_numbers(colours.lowest - zero, colours.highest - zero, rows // (3 * size))
    texts = _texts(marks)
    longest = max(font.getlength(text) for text in (*texts, degrees.value))
    gap, thick = size // 2, size
    width = int(2 * gap + thick + gap + longest + gap)
    image = Image.new("RGB", (width, rows), tuple(colours.background.tolist()))
    draw = ImageDraw.Draw(image)
    ink = (20, 20, 20) if colours.background.mean() > 127 else (235, 235, 235)
    top, bottom = 2 * size, rows - size
    steps = (np.arange(bottom - top)[::-1] * len(colours.table)) // (bottom - top)
    strip = np.repeat(colours.table[steps][:, None], thick, axis=1)
    image.paste(Image.fromarray(strip), (2 * gap, top))
    right = 2 * gap + thick
    draw.text((2 * gap, size * 0.9), degrees.value, ink, font=font, anchor="lm")
    for mark, text in zip(marks, texts, strict=True):
        share = (mark + zero - colours.lowest) / (colours.highest - colours.lowest)
        row = bottom - 0.5 - share * (bottom - top - 1)
        draw.line([(right, row), (right + gap // 2, row)], ink)
        draw.text((right + gap, row), text, ink, font=font, anchor="lm")
    return np.asarray(image)


def with_bar(
    picture: UInt8[np.ndarray, "rows columns 3"],
    colours: Colours,
    degrees: Degrees = Degrees.KELVIN,
) -> UInt8[np.ndarray, "rows wider 3"]:
    """A coloured picture with its colour bar, from T_max to T_min [K], at its right."""
    return np.concatenate([picture, colour_bar(len(picture), colours, degrees)], axis=1)


def _round_numbers(low: float, high: float, most: int) -> list[float]:
    """Round numbers within a range, at most about so many, and two where there are any."""
    for count in range(max(most, 2), 12):
        ticks = MaxNLocator(nbins=count, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
        slack = 1e-9 * (high - low)
        inside = [float(one) for one in ticks if low - slack <= one <= high + slack]
        if len(inside) >= 2:
            return inside
    return [low, high]


def _texts(marks: list[float]) -> list[str]:
    """The marks with as many digits as tell them apart, the same of each."""
    step = min(abs(b - a) for a, b in zip(marks, marks[1:], strict=False))
    for digits in range(10):
        if all(abs(round(one, digits) - one) < 1e-3 * step for one in marks):
            break
    return [f"{one:.{digits}f}" for one in marks]
