"""A body: its mesh, its material, and everything that heats, cools or holds it."""

from __future__ import annotations

from typing import final

import equinox as eqx
from jaxtyping import Array, Float

from thermo.physics._discretisation import Discretisation
from thermo.physics.effects import (
    AbstractLaw,
    AbstractSurfaceEffect,
    AbstractVolumeEffect,
    PrescribedTemperature,
)


@final
class Model(eqx.Module):
    """The heat equation on a body, rho c dT/dt = div(k grad T) + q, k dT/dn = sum of fluxes.

    - `space`: the discretised mesh.
    - `conductivity`: (cells,), or a symmetric tensor (cells, 3, 3) [W/m/K].
    - `capacity`: volumetric heat capacity, (cells,) [J/m3/K].
    - `surface`: effects on the surface [W/m2]; `volume`: effects inside [W/m3].
    - `prescribed`: nodes whose temperature is given [K], or None.
    - `conductivity_law`, `capacity_law`: factors f(T) [1], or None; the integrator then wants two
      or more iterations a stage.

    Source: paper, section 4.2 (checklist B1, B2).
    """

    space: Discretisation
    conductivity: Float[Array, " cells"] | Float[Array, "cells 3 3"]
    capacity: Float[Array, " cells"]
    surface: tuple[AbstractSurfaceEffect, ...] = ()
    volume: tuple[AbstractVolumeEffect, ...] = ()
    prescribed: PrescribedTemperature | None = None
    conductivity_law: AbstractLaw | None = None
    capacity_law: AbstractLaw | None = None

    def follows_temperature(self) -> bool:
        """Whether conductivity or capacity change with temperature."""
        return self.conductivity_law is not None or self.capacity_law is not None
