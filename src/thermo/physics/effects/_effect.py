"""What every effect answers: its flux into the body, and how that falls with temperature."""

from __future__ import annotations

from abc import abstractmethod

import equinox as eqx
from jaxtyping import Array, Float

from thermo.physics._discretisation import Discretisation

Time = float | Float[Array, ""]


class AbstractSurfaceEffect(eqx.Module):
    """Heat exchanged through the surface: q_in(T, t) [W/m2] at the face points."""

    @abstractmethod
    def flux(
        self, temperature: Float[Array, "faces points"], time: Time
    ) -> Float[Array, "faces points"]:
        """Flux into the body [W/m2] at surface temperatures [K] and a time [s]."""

    @abstractmethod
    def slope(
        self, temperature: Float[Array, "faces points"]
    ) -> Float[Array, "faces points"] | None:
        """Coefficient [W/m2/K] that the implicit matrix takes for -dq/dT; None means zero."""

    @abstractmethod
    def local(self) -> bool:
        """Whether the flux at a point depends on the temperature [K] of no other point."""


class AbstractVolumeEffect(eqx.Module):
    """Heat released inside the body."""

    @abstractmethod
    def load(self, space: Discretisation, time: Time) -> Float[Array, " nodes"]:
        """Nodal heat rate [W] at a time [s], integral of q N_i."""
