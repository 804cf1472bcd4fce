"""The candidates for a body: kinds of effects, and the places where each is looked for."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, final

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.discover._candidate import (
    SHARPNESS,
    SQUARENESS,
    Candidate,
    Inclusion,
    Place,
    Transition,
)
from thermo.discover.candidates import (
    AmbientDrift,
    AnisotropicConductivity,
    BackingConduction,
    CameraDrift,
    CameraEmissivity,
    ClockOffset,
    Evaporation,
    HeaterLag,
    HeaterPower,
    HiddenSource,
    InDepthAbsorption,
    LatentHeat,
    LocalConvection,
    MissingRadiation,
    SensorLag,
    SupportContact,
    TemperatureDependentConductivity,
    TemperatureDependentHeatCapacity,
    Void,
)
from thermo.mesh import Mesh
from thermo.observe import Run, Scene

# Places on the surface and inside, knots of a drift, temperatures of a transition [1]. Sizes over
# the longest side [1], of a transition over the distance of two of them.
_PLACES: Final = 32
_KNOTS: Final = 4
_TRANSITIONS: Final = 6
_WIDTH: Final = 0.5
_SIZE: Final = 0.12
_WIDE: Final = 2.0
_DEPTHS: Final = (0.02, 0.05, 0.1)
# By lags shorter than this share of the longest run slopes are taken as by one of it [1].
_PULSE: Final = 0.005


@final
@dataclass(frozen=True)
class Setting:
    """What is known of a scene before anything is fitted.

    - `mesh`: of the body [m]; `density`: as stated [kg/m3].
    - `duration`: of the longest run [s]; `coldest`, `hottest`: of all readings [K].
    - `unknown`: names of the quantities that are fitted beside the effects.
    """

    mesh: Mesh
    density: float
    duration: float
    coldest: float
    hottest: float
    unknown: tuple[str, ...] = ()


def _spread(points: Float[np.ndarray, "points 3"], count: int) -> Float[np.ndarray, "picked 3"]:
    """Points far from each other, each the farthest from those before [m]."""
    picked = [int(np.argmin(np.linalg.norm(points - points.mean(0), axis=1)))]
    apart = np.linalg.norm(points - points[picked[0]], axis=1)
    while len(picked) < min(count, len(points)):
        picked.append(int(np.argmax(apart)))
        apart = np.minimum(apart, np.linalg.norm(points - points[picked[-1]], axis=1))
    return points[picked]


def setting_of(
    scene: Scene, runs: Iterable[Run], mesh: Mesh, unknown: tuple[str, ...] = ()
) -> Setting:
    """What a scene and runs of it tell, on a mesh of its body [m]; `unknown`: what is fitted."""
    recordings = [run.recording for run in runs]
    read = np.concatenate([one.temperature[one.valid] for one in recordings])
    duration = max(float(one.time[-1]) for one in recordings)
    extremes = float(read.min()), float(read.max())
    return Setting(mesh, scene.material.density, duration, *extremes, unknown)


def library(setting: Setting) -> tuple[Candidate, ...]:
    """All candidates of this package at strength zero, their places [m] spread over the body."""
    mesh, duration = setting.mesh, setting.duration
    extent = np.ptp(mesh.nodes, axis=0)
    longest, least = float(extent.max()), float(extent.min())
    skin = _spread(mesh.nodes[mesh.faces[:, :3]].mean(1), _PLACES)
    inside = _spread(mesh.nodes[mesh.cells[:, :4]].mean(1), _PLACES)
    on_skin, within = (
        Place(jnp.asarray(points), jnp.full(len(points), _SIZE * longest))
        for points in (skin, inside)
    )

    patches = on_skin
    if not {"convection", "scaled_convection"} & set(setting.unknown):
        # Where it is not fitted, convection may be wrong all over.
        middle = (mesh.nodes.min(0) + mesh.nodes.max(0)) / 2
        patches = Place(
            jnp.asarray(np.vstack([skin, middle])), jnp.append(on_skin.size, _WIDE * longest)
        )

    # Along each axis a share of the body there, so that a void is as flat as the body is.
    sizes = jnp.broadcast_to(jnp.asarray(_SIZE * extent), inside.shape)
    ones = jnp.ones(len(inside))
    flat = Inclusion(jnp.asarray(inside), sizes, SQUARENESS[0] * ones, SHARPNESS[0] * ones)

    def zero(parts: int = 1) -> Float[Array, " parts"]:
        return jnp.zeros(parts)

    return (
        MissingRadiation(zero()),
        LocalConvection(zero(len(patches.size)), patches),
        SupportContact(zero(6), Place(None, 0.1 * jnp.asarray([*extent, *extent]))),
        BackingConduction(zero(6)),
        AmbientDrift(zero(_KNOTS), duration=jnp.asarray(duration)),
        Evaporation(zero()),
        HiddenSource(zero(len(inside)), within),
        HeaterPower(zero()),
        HeaterLag(zero(), pulse=jnp.asarray(_PULSE * duration)),
        InDepthAbsorption(zero(len(_DEPTHS)), Place(None, least * jnp.asarray(_DEPTHS))),
        AnisotropicConductivity(zero(3)),
        Void(zero(len(inside)), flat),
        SensorLag(zero()),
        ClockOffset(zero()),
        CameraEmissivity(zero()),
        CameraDrift(zero()),
        TemperatureDependentConductivity(zero()),
        TemperatureDependentHeatCapacity(zero()),
        LatentHeat(zero(_TRANSITIONS), _transitions(setting), jnp.asarray(setting.density)),
    )


def _transitions(setting: Setting) -> Transition:
    """Transitions spread over what was read [K]."""
    apart = (setting.hottest - setting.coldest) / _TRANSITIONS
    middle = setting.coldest + apart * (jnp.arange(_TRANSITIONS) + 0.5)
    return Transition(middle, jnp.full(_TRANSITIONS, _WIDTH * apart))
