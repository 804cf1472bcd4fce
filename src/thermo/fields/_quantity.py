"""The thermophysical quantities that can be unknown: symbol, SI unit, bounds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, final


@final
@dataclass(frozen=True)
class Quantity:
    """A property of the material or of the surface.

    - `name`, `symbol`, `unit`: as in files, formulas and tables; `unit` is SI.
    - `lower`, `upper`: bounds of what is physical, in `unit`.
    - `place`: whether it lives in the cells or on the faces.
    """

    name: str
    symbol: str
    unit: str
    lower: float
    upper: float
    place: Literal["cells", "faces"]


_ALL = (
    Quantity("conductivity", "k", "W/m/K", 1e-3, 5e3, "cells"),
    Quantity("diffusivity", "alpha", "m2/s", 1e-9, 1e-2, "cells"),
    Quantity("volumetric_heat_capacity", "rho c", "J/m3/K", 1e3, 1e8, "cells"),
    Quantity("convection", "h", "W/m2/K", 1e-2, 1e5, "faces"),
    Quantity("emissivity", "eps", "1", 1e-3, 1.0, "faces"),
    Quantity("scaled_convection", "beta", "m/s", 1e-9, 1e-1, "faces"),
    Quantity("scaled_emissivity", "gamma", "m3 K/J", 1e-10, 1e-3, "faces"),
)

QUANTITIES: Mapping[str, Quantity] = MappingProxyType({item.name: item for item in _ALL})
"""Every quantity that a fit can take as unknown, by name."""
