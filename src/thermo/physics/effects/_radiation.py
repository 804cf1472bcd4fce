"""Radiation to surroundings of one temperature."""

from __future__ import annotations

from typing import final

import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.physics.effects._effect import AbstractSurfaceEffect, Time
from thermo.physics.effects._schedule import History, value_at

STEFAN_BOLTZMANN = 5.670374419e-8
"""Stefan-Boltzmann constant [W/m2/K4] (CODATA 2018)."""


def _exchange(
    emissivity: Float[Array, " faces"],
    temperature: Float[Array, "faces points"],
    surroundings: Float[Array, ""],
) -> Float[Array, "faces points"]:
    # The difference of fourth powers as a product keeps all digits near equilibrium.
    pair = (surroundings + temperature) * (surroundings**2 + temperature**2)
    return emissivity[:, None] * STEFAN_BOLTZMANN * pair


@final
class Radiation(AbstractSurfaceEffect):
    """Grey radiation q = eps sigma (T_env^4 - T^4), linearised by its true derivative.

    - `emissivity`: of each face, (faces,) [1].
    - `surroundings`: T_env [K], absolute, constant or a history.

    Source: paper, boundary condition (checklist B2).
    """

    emissivity: Float[Array, " faces"]
    surroundings: Float[Array, ""] | float | History

    def flux(
        self, temperature: Float[Array, "faces points"], time: Time
    ) -> Float[Array, "faces points"]:
        """Flux into the body [W/m2] at surface temperatures [K] and a time [s]."""
        outside = value_at(self.surroundings, time)
        return _exchange(self.emissivity, temperature, outside) * (outside - temperature)

    def local(self) -> bool:
        """Yes: the flux at a point knows no other temperature [K]."""
        return True

    def slope(self, temperature: Float[Array, "faces points"]) -> Float[Array, "faces points"]:
        """Coefficient of the implicit matrix, 4 eps sigma T^3 [W/m2/K]."""
        return 4 * STEFAN_BOLTZMANN * self.emissivity[:, None] * temperature**3


@final
class LaggedRadiation(AbstractSurfaceEffect):
    """The paper's radiation: a coefficient from the step before, used as in convection.

    q = h_r (T_env - T) with h_r = eps sigma (T_old^2 + T_env^2)(T_old + T_env); with backward
    Euler this is the paper's scheme, first order in the step.

    - `emissivity`: of each face, (faces,) [1].
    - `surroundings`: T_env [K], absolute and constant.

    Source: paper, appendix B.3 (checklist B4).
    """

    emissivity: Float[Array, " faces"]
    surroundings: Float[Array, ""] | float

    def flux(
        self, temperature: Float[Array, "faces points"], time: Time
    ) -> Float[Array, "faces points"]:
        """Flux into the body [W/m2] at surface temperatures [K] and a time [s]."""
        del time
        outside = jnp.asarray(self.surroundings)
        return _exchange(self.emissivity, temperature, outside) * (outside - temperature)

    def local(self) -> bool:
        """Yes: the flux at a point knows no other temperature [K]."""
        return True

    def slope(self, temperature: Float[Array, "faces points"]) -> Float[Array, "faces points"]:
        """Coefficient of the implicit matrix, h_r [W/m2/K]."""
        return _exchange(self.emissivity, temperature, jnp.asarray(self.surroundings))
