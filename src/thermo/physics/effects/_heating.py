"""Heating by a lamp or through a patch, and heat released inside."""

from __future__ import annotations

from typing import final

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.physics._discretisation import Discretisation, volume_load
from thermo.physics.effects._effect import AbstractSurfaceEffect, AbstractVolumeEffect, Time
from thermo.physics.effects._schedule import History, Schedule, value_at


@final
class Heating(AbstractSurfaceEffect):
    """Flux q = power * profile * s(t) into the surface, whatever its temperature.

    - `power`: [W] absorbed at full power.
    - `profile`: share of the power, (faces, points) [1/m2]; its surface integral is one.
    - `schedule`: when it is on.

    Source: paper, appendix B.3 (checklist B6).
    """

    power: Float[Array, ""] | float
    profile: Float[Array | np.ndarray, "faces points"]
    schedule: Schedule

    def flux(
        self, temperature: Float[Array, "faces points"], time: Time
    ) -> Float[Array, "faces points"]:
        """Flux into the body [W/m2] at a time [s]; surface temperatures [K] do not matter."""
        del temperature
        return self.power * self.schedule.share(time) * jnp.asarray(self.profile)

    def local(self) -> bool:
        """Yes: the flux at a point knows no other temperature [K]."""
        return True

    def slope(self, temperature: Float[Array, "faces points"]) -> None:
        """None: the flux does not depend on the temperature [K]."""
        del temperature


@final
class PrescribedFlux(AbstractSurfaceEffect):
    """A given flux into each face, constant or with a common history.

    - `density`: (faces,) [W/m2] at factor one.
    - `factor`: [1], constant or a history.
    """

    density: Float[Array, " faces"]
    factor: Float[Array, ""] | float | History = 1.0

    def flux(
        self, temperature: Float[Array, "faces points"], time: Time
    ) -> Float[Array, "faces points"]:
        """Flux into the body [W/m2] at a time [s]; surface temperatures [K] do not matter."""
        level = self.density * value_at(self.factor, time)
        return jnp.broadcast_to(level[:, None], temperature.shape)

    def local(self) -> bool:
        """Yes: the flux at a point knows no other temperature [K]."""
        return True

    def slope(self, temperature: Float[Array, "faces points"]) -> None:
        """None: the flux does not depend on the temperature [K]."""
        del temperature


@final
class VolumetricSource(AbstractVolumeEffect):
    """Heat released in the cells.

    - `density`: (cells,) [W/m3] at full power; `schedule`: when it is on.
    """

    density: Float[Array, " cells"]
    schedule: Schedule

    def load(self, space: Discretisation, time: Time) -> Float[Array, " nodes"]:
        """Nodal heat rate [W] at a time [s]."""
        return volume_load(space, self.density * self.schedule.share(time))


@final
class NodalSource(AbstractVolumeEffect):
    """Heat released inside, integrated beforehand.

    - `rate`: integral of q N_i at full power, (nodes,) [W]; `schedule`: when it is on.
    """

    rate: Float[Array, " nodes"]
    schedule: Schedule

    def load(self, space: Discretisation, time: Time) -> Float[Array, " nodes"]:
        """Nodal heat rate [W] at a time [s]."""
        del space
        return self.rate * self.schedule.share(time)


def spot_profile(
    space: Discretisation,
    *,
    centre: Float[np.ndarray, " 3"],
    direction: Float[np.ndarray, " 3"],
    radius: float,
) -> Float[np.ndarray, "faces points"]:
    """Profile [1/m2] of a lamp: exp(-r^2 / (2 radius^2)) max(-n . direction, 0), integral one.

    Arguments:

    - `centre`: a point on the axis, (3,) [m]; `direction`: in which the light goes, (3,) [1].
    - `radius`: [m].

    Raises `ValueError` where the lamp does not meet the surface.

    Source: the scene format, key `heater`.
    """
    axis = np.asarray(direction, float) / np.linalg.norm(direction)
    offset = np.asarray(space.face_point) - np.asarray(centre)
    across = offset - (offset @ axis)[..., None] * axis
    facing = np.maximum(-(np.asarray(space.mesh.normals) @ axis), 0.0)
    shape = np.exp(-(across**2).sum(-1) / (2 * radius**2)) * facing[:, None]
    total = float((shape * space.face_weight).sum())
    if not total > 0:
        raise ValueError("the lamp's axis does not meet the surface")
    return shape / total


def patch_profile(space: Discretisation, faces: np.ndarray) -> Float[np.ndarray, "faces points"]:
    """Profile [1/m2] of a heater that covers the given faces evenly; its integral is one."""
    shape = np.zeros(np.shape(space.face_weight))
    shape[faces] = 1.0
    return shape / (shape * space.face_weight).sum()
