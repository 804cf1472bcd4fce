"""The candidates for a body: kinds of effects, and the places where each is looked for."""

from __future__ import annotations

from typing import Final

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.discover._candidate import Candidate, Place
from thermo.discover.candidates import (
    AmbientDrift,
    AnisotropicConductivity,
    BackingConduction,
    CameraEmissivity,
    ClockOffset,
    Evaporation,
    HeaterLag,
    HeaterPower,
    HiddenSource,
    InDepthAbsorption,
    LocalConvection,
    MissingRadiation,
    SensorLag,
    SupportContact,
    TemperatureDependentConductivity,
    TemperatureDependentHeatCapacity,
    Void,
)
from thermo.mesh import Mesh

# Places on the surface and inside; knots of a drift [1]. Sizes over the longest side [1].
_PLACES: Final = 32
_KNOTS: Final = 4
_SIZE: Final = 0.12
_DEPTHS: Final = (0.02, 0.05, 0.1)


def _spread(points: Float[np.ndarray, "points 3"], count: int) -> Float[np.ndarray, "picked 3"]:
    """Points far from each other, each the farthest from those before [m]."""
    picked = [int(np.argmin(np.linalg.norm(points - points.mean(0), axis=1)))]
    apart = np.linalg.norm(points - points[picked[0]], axis=1)
    while len(picked) < min(count, len(points)):
        picked.append(int(np.argmax(apart)))
        apart = np.minimum(apart, np.linalg.norm(points - points[picked[-1]], axis=1))
    return points[picked]


def library(mesh: Mesh, duration: float) -> tuple[Candidate, ...]:
    """All candidates of this package at strength zero.

    Arguments: `mesh`: of the body [m]; `duration`: of the longest run [s].
    """
    extent = np.ptp(mesh.nodes, axis=0)
    longest, least = float(extent.max()), float(extent.min())
    skin = _spread(mesh.nodes[mesh.faces[:, :3]].mean(1), _PLACES)
    inside = _spread(mesh.nodes[mesh.cells[:, :4]].mean(1), _PLACES)
    on_skin, within = (
        Place(jnp.asarray(points), jnp.full(len(points), _SIZE * longest))
        for points in (skin, inside)
    )

    # Along each axis a share of the body there, so that a void is as flat as the body is.
    flat = Place(within.centre, jnp.broadcast_to(jnp.asarray(_SIZE * extent), inside.shape))

    def zero(parts: int = 1) -> Float[Array, " parts"]:
        return jnp.zeros(parts)

    return (
        MissingRadiation(zero()),
        LocalConvection(zero(len(skin)), on_skin),
        SupportContact(zero(6), Place(None, 0.1 * jnp.asarray([*extent, *extent]))),
        BackingConduction(zero(6)),
        AmbientDrift(zero(_KNOTS), duration=jnp.asarray(duration)),
        Evaporation(zero()),
        HiddenSource(zero(len(inside)), within),
        HeaterPower(zero()),
        HeaterLag(zero()),
        InDepthAbsorption(zero(len(_DEPTHS)), Place(None, least * jnp.asarray(_DEPTHS))),
        AnisotropicConductivity(zero(3)),
        Void(zero(len(inside)), flat),
        SensorLag(zero()),
        ClockOffset(zero()),
        CameraEmissivity(zero()),
        TemperatureDependentConductivity(zero()),
        TemperatureDependentHeatCapacity(zero()),
    )
