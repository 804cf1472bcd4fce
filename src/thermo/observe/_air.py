"""Air over a part of the surface, where it is not that of the rest."""

from __future__ import annotations

from typing import final

import equinox as eqx

from ._box import Box
from ._kelvin import check_kelvin_number
from ._number import check_number


@final
class Air(eqx.Module):
    """Air whose convection over the faces whose centre lies in a box is known.

    There q = h (T_air - T) with this h, whatever coefficient the scene states or a fit finds for
    the rest of the surface. Radiation goes on as elsewhere.

    Arguments:

    - `box`: where it is [m].
    - `convection`: h [W/m2/K]; 0 where no air reaches.
    - `temperature`: T_air [K].
    - `where`: what messages call this air.

    Raises `InputError` for a negative coefficient, and a temperature that cannot be kelvin.

    Source: paper, boundary condition (checklist B2), by parts of the surface.
    """

    box: Box
    convection: float
    temperature: float

    def __init__(
        self, box: Box, convection: float, temperature: float, *, where: str = "air"
    ) -> None:
        self.box = box
        self.convection = check_number(
            convection, where=f"{where}.convection", quantity="convection coefficient [W/m2/K]",
            least=0.0, remedy="give W/m2/K (still air: 2 to 10)",
        )  # fmt: skip
        self.temperature = check_kelvin_number(
            temperature, where=f"{where}.temperature", quantity="temperature of the air"
        )
