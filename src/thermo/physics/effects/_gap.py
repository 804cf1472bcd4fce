"""Heat exchanged across a gap between two facing parts of the surface."""

from __future__ import annotations

from typing import final

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int
from scipy.spatial import KDTree

from thermo.errors import InputError
from thermo.physics._discretisation import Discretisation
from thermo.physics.effects._effect import AbstractSurfaceEffect, Time


@final
class GapExchange(AbstractSurfaceEffect):
    """Exchange between faces that face each other, q = g (T_other - T), as across a thin gap.

    The step's matrix holds g on its own side only: the other side enters with the temperature of
    the last iteration. Use `BackwardEuler`; with one iteration the exchange is first order in the
    step, and a steady state is met whatever the number of iterations.

    - `conductance`: g of each face, (faces,) [W/m2/K], equal on both sides; zero off the gap.
    - `other`: the face on the other side, (faces,), or the face itself.
    - `point`: which of its quadrature points lies opposite, (faces, points).

    Source: Carslaw and Jaeger, Conduction of Heat in Solids, section 1.9.
    """

    conductance: Float[Array | np.ndarray, " faces"]
    other: Int[Array | np.ndarray, " faces"]
    point: Int[Array | np.ndarray, "faces points"]

    def flux(
        self, temperature: Float[Array, "faces points"], time: Time
    ) -> Float[Array, "faces points"]:
        """Flux into the body [W/m2] at surface temperatures [K]; the time [s] does not matter."""
        del time
        opposite = temperature[self.other[:, None], self.point]
        return jnp.asarray(self.conductance)[:, None] * (opposite - temperature)

    def local(self) -> bool:
        """No: it depends on the temperature on the other side [K]."""
        return False

    def slope(self, temperature: Float[Array, "faces points"]) -> Float[Array, "faces points"]:
        """Coefficient of the implicit matrix, g [W/m2/K]."""
        return jnp.broadcast_to(jnp.asarray(self.conductance)[:, None], temperature.shape)


def gap_exchange(
    space: Discretisation,
    first: Int[np.ndarray, " some"],
    second: Int[np.ndarray, " others"],
    conductance: float,
) -> GapExchange:
    """Exchange across the gap between two patches whose faces match when one is shifted.

    Arguments:

    - `first`, `second`: faces of the two sides; the same triangles but for a shift.
    - `conductance`: g [W/m2/K].

    Raises `InputError` where the two sides do not match.
    """
    count, points = np.shape(space.face_weight)
    place = np.asarray(space.face_point)
    shift = place[second].mean((0, 1)) - place[first].mean((0, 1))
    size = np.sqrt(np.asarray(space.face_weight)[first].sum(1).min())
    tree = KDTree(place[second].reshape(-1, 3))
    away, near = tree.query(place[first] + shift)
    if len(first) != len(second) or away.max() > 1e-6 * size:
        raise InputError(
            "the two sides of the gap do not match",
            where="gap",
            value=f"{len(first)} and {len(second)} faces, {away.max():.3g} m apart after a shift",
            limit="the same triangles on both sides",
            remedy="mesh both sides alike, or model each side with Contact",
        )
    other = np.arange(count)
    point = np.tile(np.arange(points), (count, 1))
    facing = np.asarray(second)[near // points]  # (some, points)
    other[first], point[first] = facing[:, 0], near % points
    rows = np.asarray(first)[:, None]
    other[facing[:, 0]] = first
    point[facing, near % points] = np.arange(points) + 0 * rows
    level = np.zeros(count)
    level[first] = level[second] = conductance
    return GapExchange(level, other.astype(np.int32), point.astype(np.int32))
