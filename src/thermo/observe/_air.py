"""Air over a part of the surface, where it is not that of the rest."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from ._box import Box
from ._kelvin import check_kelvin_number
from ._number import check_number


@final
class Air(eqx.Module):
    """Air whose convection over the faces whose centre lies in a box is known.

    There q = h (T_air - T) with this h, whatever coefficient the scene states or a fit finds for
    the rest of the surface. Radiation goes on as elsewhere.

    Arguments:

    - `box_min`, `box_max`: opposite corners of the box, (3,) [m]; its sides count as inside.
    - `convection`: h [W/m2/K]; 0 where no air reaches.
    - `temperature`: T_air [K].
    - `where`: what messages call this air.

    Raises `InputError` for a box that is inside out, a negative coefficient, and a temperature that
    cannot be kelvin.
    """

    box_min: Float[np.ndarray, "3"]
    box_max: Float[np.ndarray, "3"]
    convection: float
    temperature: float

    def __init__(
        self,
        box_min: ArrayLike,
        box_max: ArrayLike,
        convection: float,
        temperature: float,
        *,
        where: str = "air",
    ) -> None:
        box = Box(box_min, box_max, where=f"{where}.box")
        self.box_min, self.box_max = box.low, box.high
        self.convection = check_number(
            convection, where=f"{where}.convection", quantity="convection coefficient [W/m2/K]",
            least=0.0, remedy="give W/m2/K (still air: 2 to 10)",
        )  # fmt: skip
        self.temperature = check_kelvin_number(
            temperature, where=f"{where}.temperature", quantity="temperature of the air"
        )

    def box(self) -> Box:
        """Where it is [m]."""
        return Box(self.box_min, self.box_max)
