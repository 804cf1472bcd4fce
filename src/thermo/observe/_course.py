"""A power that was logged over time."""

from __future__ import annotations

from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from thermo.errors import InputError

from ._number import real_array
from ._recording import check_time

# No lamp gives more than this over what is stated of it [1].
_MOST: Final = 10.0


@final
class Course(eqx.Module):
    """Shares of a lamp's power over time, linear in between and constant outside.

    Arguments:

    - `time`: (points,) [s], increasing.
    - `share`: (points,) of the stated power, two or more [1].
    - `where`: what messages call this course.

    Raises `InputError` for time that does not increase, shapes that do not fit, and shares that
    are not finite, negative, all zero, or per cent.
    """

    time: Float[np.ndarray, " points"]
    share: Float[np.ndarray, " points"]

    def __init__(self, time: ArrayLike, share: ArrayLike, *, where: str = "course") -> None:
        self.time = check_time(time, where=f"{where}.time", earliest=None)
        self.share = real_array(share, where=f"{where}.share", quantity="share of the power [1]")
        if self.share.shape != self.time.shape:
            raise InputError(
                "course does not fit its times", where=f"{where}.share",
                value=f"shape {self.share.shape}", limit=f"shape {self.time.shape}, one a time",
                remedy="give as many shares as times",
            )  # fmt: skip
        sound = np.isfinite(self.share).all() and (self.share >= 0).all()
        sound = sound and self.share.max() <= _MOST
        if not (sound and self.share.any()):
            raise InputError(
                "a share of the power is out of range", where=f"{where}.share",
                value=f"{self.share.min():g} to {self.share.max():g}",
                limit=f"finite, at least 0, at most {_MOST:g}, and above 0 at some time",
                remedy="give what was logged over `power`, as a fraction and not per cent; "
                'without a lamp write "heater": null',
            )  # fmt: skip
