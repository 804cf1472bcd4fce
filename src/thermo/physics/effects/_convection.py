"""Convection to surroundings, and contact with a support: both exchange in proportion."""

from __future__ import annotations

from typing import final

import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.physics.effects._effect import AbstractSurfaceEffect, Time
from thermo.physics.effects._schedule import History, value_at

Shares = Float[Array, "faces *points"]
"""A number of each face, or of each of its points."""


def _at_points(of: Shares) -> Float[Array, "faces points"]:
    return of.reshape(len(of), -1)


@final
class Convection(AbstractSurfaceEffect):
    """Newton's law q = h (T_ambient + warmer - T).

    - `coefficient`: h of each face, (faces,), or of its points, (faces, points) [W/m2/K]; zero
      where it does not exchange.
    - `ambient`: [K], constant or a history.
    - `warmer`: by how much the air is warmer than that on each face, (faces,) [K]; nowhere if None.

    Source: paper, boundary condition (checklist B2).
    """

    coefficient: Shares
    ambient: Float[Array, ""] | float | History
    warmer: Float[Array, " faces"] | None = None

    def flux(
        self, temperature: Float[Array, "faces points"], time: Time
    ) -> Float[Array, "faces points"]:
        """Flux into the body [W/m2] at surface temperatures [K] and a time [s]."""
        air = value_at(self.ambient, time)
        if self.warmer is not None:
            air = air + self.warmer[:, None]
        return _at_points(self.coefficient) * (air - temperature)

    def local(self) -> bool:
        """Yes: the flux at a point knows no other temperature [K]."""
        return True

    def slope(self, temperature: Float[Array, "faces points"]) -> Float[Array, "faces points"]:
        """Coefficient of the implicit matrix, h [W/m2/K]."""
        return jnp.broadcast_to(_at_points(self.coefficient), temperature.shape)


@final
class Contact(AbstractSurfaceEffect):
    """Contact with a support that keeps its own temperature, q = g (T_support - T).

    - `conductance`: g of each face, (faces,), or of its points, (faces, points) [W/m2/K]; zero off
      the support.
    - `support`: [K], constant or a history.

    Source: Carslaw and Jaeger, Conduction of Heat in Solids, section 1.9.
    """

    conductance: Shares
    support: Float[Array, ""] | float | History

    def flux(
        self, temperature: Float[Array, "faces points"], time: Time
    ) -> Float[Array, "faces points"]:
        """Flux into the body [W/m2] at surface temperatures [K] and a time [s]."""
        return _at_points(self.conductance) * (value_at(self.support, time) - temperature)

    def local(self) -> bool:
        """Yes: the flux at a point knows no other temperature [K]."""
        return True

    def slope(self, temperature: Float[Array, "faces points"]) -> Float[Array, "faces points"]:
        """Coefficient of the implicit matrix, g [W/m2/K]."""
        return jnp.broadcast_to(_at_points(self.conductance), temperature.shape)
