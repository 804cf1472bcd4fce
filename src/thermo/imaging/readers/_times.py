"""Times of frames, from the file's own stamps or from what is stated."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError

from ._stated import Stated

_CALENDAR: Final = 1e8
"""First stamps above this, three years [s], count from a calendar's date and from no run."""


def times_of(
    count: int, given: Stated, *, stamps: Float[np.ndarray, " stamps"] | None, where: str
) -> Float[np.ndarray, " times"]:
    """Times of `count` frames [s].

    Stated times come first, then the file's own `stamps` [s], then a stated rate; one frame needs
    none of them. Stamps are shifted such that the first is at `given.start`; where that is left
    out they stand, unless they are a calendar's, which begin at 0.

    Raises `InputError`, naming `where`, if nothing tells the times.
    """
    start = given.start if given.start is not None else 0.0
    if given.times is not None:
        return given.times
    if stamps is not None and stamps.size:
        shifts = given.start is not None or abs(stamps[0]) > _CALENDAR
        return (stamps - stamps[0]) + start if shifts else stamps
    if given.rate is not None:
        return start + np.arange(count) / given.rate
    if count == 1:
        return np.array([start])
    raise InputError(
        "nothing tells the times of these frames", where=where,
        value=f"{count} frames, no stamps that tell them apart",
        limit="time stamps in the file, or `rate` [Hz] or `times` [s] stated",
        remedy="state recording.rate, such as 30 for 30 frames a second, or recording.times (from "
        "Python rate or times of Stated); of a folder times.csv in it may say them",
    )  # fmt: skip
