"""Effects of what is around the body."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar, Final, final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.discover._candidate import AbstractHeatCandidate, Card, Inclusion, Place
from thermo.discover.candidates._covered_faces import covered
from thermo.inverse import Conditions
from thermo.physics import Discretisation, Model, triangle_rule
from thermo.physics.effects import (
    AbstractSurfaceEffect,
    Contact,
    Convection,
    History,
    Radiation,
    value_at,
)

# Cosine of the angle to a side within which a face of the surface is a part of it, and over the
# diagonal of the body twice how far the loosest mesh lies off its surface [1].
_FLAT: Final = 1 - 1e-5
_OFF: Final = 4e-3

Time = float | Float[Array, ""]


def _also(model: Model, effect: AbstractSurfaceEffect) -> Model:
    return replace(model, surface=(*model.surface, effect))


@final
class MissingRadiation(AbstractHeatCandidate):
    """Radiation beyond what is stated, by an emissivity that is higher by the strength."""

    card: ClassVar[Card] = Card(
        "radiation", "1", 1.0, -1.0, 1.0,
        excited_by="surface temperatures over a wide range",
        hides_behind="convection, a drift of the surroundings, evaporation",
        split_by="a second power, vacuum, a tape of low emissivity",
        means="emissivity beyond what is stated",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | None = None

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with more radiation in it."""
        return _also(model, Radiation(self.strength[0] * under.exposed, under.surroundings))


@final
class LocalConvection(AbstractHeatCandidate):
    """Convection that is stronger on a patch, h(x) = h + strength exp(-r^2 / (2 size^2)).

    Or on one with an edge, within an `Inclusion`.
    """

    card: ClassVar[Card] = Card(
        "local_convection", "W/m2/K", 100.0, -np.inf, np.inf,
        excited_by="a patch well above the surroundings",
        hides_behind="contact at the same patch",
        split_by="a fan that is turned off, the body turned round",
        alike="a support under that place",
        means="convection beyond what is stated, in the middle of a patch",
        edged=True,
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | Inclusion

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with more convection on patches."""
        shapes = self.place.shapes(jnp.asarray(model.space.face_point))
        patches = jnp.einsum("p,pfq->fq", self.strength, shapes)
        film = patches * under.exposed[:, None]
        return _also(model, Convection(film, under.ambient, under.warmer))


@final
class SupportContact(AbstractHeatCandidate):
    """Contact with a support under one side, over a footprint of some depth.

    q = strength (T_support - T) where the surface lies within `depth` of the side's end of the
    body; the support is as warm as the surroundings. Sides are -x, -y, -z, +x, +y, +z, and the
    sizes of their places the depths: next to nothing where a support ends with a flat side, all of
    which is in contact then, though nodes lie off it by more.

    Source: Carslaw and Jaeger, Conduction of Heat in Solids, section 1.9.
    """

    card: ClassVar[Card] = Card(
        "support_contact", "W/m2/K", 500.0, 0.0, np.inf,
        excited_by="heat that passes the support",
        hides_behind="convection that is stronger there, a source",
        split_by="a support that is moved or insulated",
        smallest=1e-3,
        means="heat to the support for each kelvin and area",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with a support under its sides."""
        return _also(model, Contact(self._footprints(model.space) @ self.strength, under.ambient))

    def _footprints(self, space: Discretisation) -> Float[Array, "faces points sides"]:
        nodes = jnp.asarray(space.mesh.nodes)
        corners = nodes[space.mesh.faces[:, :3]]
        height = jnp.concatenate([corners - nodes.min(0), nodes.max(0) - corners], axis=-1)
        normals = jnp.asarray(space.mesh.normals)
        ends = jnp.concatenate([-normals, normals], axis=-1) >= _FLAT
        ends &= height.max(1) <= _OFF * jnp.linalg.norm(jnp.ptp(nodes, axis=0))
        height = jnp.where(ends[:, None], 0.0, height)
        points, _ = triangle_rule(space.mesh.order)
        return jnp.einsum("qc,fcs->fqs", points, covered(height, self.place.size))


@final
class BackingFlow(AbstractSurfaceEffect):
    """q = effusivity (T_start - T) / sqrt(pi (t + delay)), a half-space that begins at T_start.

    - `effusivity`: (faces,) [W s^1/2 / m2 / K]; `start`: [K].
    """

    effusivity: Float[Array, " faces"]
    start: Float[Array, ""]

    def flux(
        self, temperature: Float[Array, "faces points"], time: Time
    ) -> Float[Array, "faces points"]:
        """Flux into the body [W/m2] at surface temperatures [K] and a time [s]."""
        # Of a step at t = 0, with a second to take it; one that warms evenly loses twice as much.
        rate = self.effusivity[:, None] / jnp.sqrt(jnp.pi * (jnp.asarray(time) + 1.0))
        return rate * (self.start - temperature)

    def local(self) -> bool:
        """Yes: the flux at a point knows no other temperature [K]."""
        return True

    def slope(self, temperature: Float[Array, "faces points"]) -> None:
        """None [W/m2/K]: the time is not known here, and the flux is weak."""
        del temperature


@final
class BackingConduction(AbstractHeatCandidate):
    """Loss into a thick body behind one side, by that body's effusivity.

    Source: Carslaw and Jaeger, Conduction of Heat in Solids, section 2.4.
    """

    card: ClassVar[Card] = Card(
        "backing_conduction", "W s^0.5/m2/K", 1000.0, 0.0, np.inf,
        excited_by="long runs",
        hides_behind="contact with a support, convection",
        split_by="a run with another backing",
        means="effusivity of the body behind, for heat that enters as after a step in temperature",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | None = None

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with a body behind its sides -x, -y, -z, +x, +y, +z."""
        normals = jnp.asarray(model.space.mesh.normals)
        facing = jnp.concatenate([-normals, normals], 1) > 0.9
        return _also(model, BackingFlow(facing @ self.strength, under.initial))


@final
class AmbientDrift(AbstractHeatCandidate):
    """Air that changes over the run, by straight lines between evenly spread knots.

    The strengths are the rises at the knots after the start; the last is that at the end. They
    reach convection alone: walls that warm with the air read as air that warms more. Only where
    there is no convection at all they are those of the walls.

    - `duration`: time of the last knot [s].
    """

    card: ClassVar[Card] = Card(
        "ambient_drift", "K", 10.0, -50.0, 50.0,
        excited_by="long runs",
        hides_behind="radiation, convection, walls that drift",
        split_by="the surroundings logged; a repeat in reverse order",
        alike="air and walls that warm together, by less",
        joint=True,
        means="how much warmer the air is at the end",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    duration: Float[Array, ""] = eqx.field(kw_only=True)
    place: Place | None = None

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] in air that drifts."""
        time = jnp.linspace(0.0, 1.0, len(self.strength) + 1) * self.duration
        rise = jnp.concatenate([jnp.zeros(1), self.strength])
        films = [one.coefficient for one in model.surface if isinstance(one, Convection)]
        air = sum(jnp.sum(jnp.abs(one)) for one in films)
        walls = jnp.where(jnp.asarray(air) > 0, 0.0, rise)

        def drifting(effect: AbstractSurfaceEffect) -> AbstractSurfaceEffect:
            if isinstance(effect, Convection):
                return replace(effect, ambient=_raised(effect.ambient, time, rise))
            if isinstance(effect, Radiation):
                return replace(effect, surroundings=_raised(effect.surroundings, time, walls))
            return effect

        return replace(model, surface=tuple(drifting(effect) for effect in model.surface))


def _raised(
    level: Float[Array, ""] | float | History,
    time: Float[Array, " knots"],
    rise: Float[Array, " knots"],
) -> History:
    """A level [K] with a rise on it; where it has a course of its own, both courses together."""
    if not isinstance(level, History):
        return History(time, value_at(level, 0.0) + rise)
    every = jnp.sort(jnp.concatenate([time, level.time]))
    return History(every, jax.vmap(level.at)(every) + jnp.interp(every, time, rise))


@final
class Vapour(AbstractSurfaceEffect):
    """Heat that evaporating water takes, q = strength (p(T_air) / 2 - p(T)), air half saturated.

    - `coefficient`: (faces,) [W/m2/Pa]; `air`: [K].

    Source: Magnus's formula for p, Alduchov and Eskridge, J. Appl. Meteor. 35 (1996) 601.
    """

    coefficient: Float[Array, " faces"]
    air: Float[Array, ""]

    def flux(
        self, temperature: Float[Array, "faces points"], time: Time
    ) -> Float[Array, "faces points"]:
        """Flux into the body [W/m2] at surface temperatures [K]."""
        del time
        apart = 0.5 * saturation(self.air) - saturation(temperature)
        return self.coefficient[:, None] * apart

    def local(self) -> bool:
        """Yes: the flux at a point knows no other temperature [K]."""
        return True

    def slope(self, temperature: Float[Array, "faces points"]) -> Float[Array, "faces points"]:
        """Coefficient of the implicit matrix [W/m2/K]."""
        grows = 17.625 * 243.04 / (temperature - 30.11) ** 2
        return self.coefficient[:, None] * saturation(temperature) * grows


def saturation(temperature: Float[Array, "*any"]) -> Float[Array, "*any"]:
    """Pressure of saturated vapour [Pa] at temperatures [K]."""
    return 610.94 * jnp.exp(17.625 * (temperature - 273.15) / (temperature - 30.11))


@final
class Evaporation(AbstractHeatCandidate):
    """Water that evaporates from the whole surface."""

    card: ClassVar[Card] = Card(
        "evaporation", "W/m2/Pa", 0.05, 0.0, np.inf,
        excited_by="a wet start, a warm skin",
        hides_behind="the camera's scale, radiation, convection",
        split_by="a dry or sealed repeat",
        means="heat for each area and pascal of vapour pressure, into air half saturated",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | None = None

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with a wet surface."""
        return _also(model, Vapour(self.strength[0] * under.exposed, under.ambient))
