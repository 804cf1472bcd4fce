"""Effects on how heat comes in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar, final

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.discover._candidate import (
    AbstractHeatCandidate,
    Card,
    Place,
    in_cells,
)
from thermo.inverse import Conditions
from thermo.physics import Model
from thermo.physics.effects import Heating, Schedule, VolumetricSource


def _lamps(model: Model, change: Callable[[Heating], Heating]) -> Model:
    surface = tuple(change(one) if isinstance(one, Heating) else one for one in model.surface)
    return replace(model, surface=surface)


@final
class HiddenSource(AbstractHeatCandidate):
    """Heat released inside, its density as exp(-r^2 / (2 size^2)), all the time."""

    card: ClassVar[Card] = Card(
        "hidden_source", "W", 5.0, -np.inf, np.inf,
        excited_by="any run, best without a lamp",
        hides_behind="contact, the lamp's power",
        split_by="a run without a lamp that starts as warm as the surroundings",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with sources in it."""
        del under
        shapes = in_cells(model.space, self.place)
        volume = jnp.asarray(model.space.volume)
        density = (self.strength / jnp.maximum(shapes @ volume, 1e-30)) @ shapes
        always = Schedule(jnp.asarray(1e12), jnp.asarray(0.0))
        return replace(model, volume=(*model.volume, VolumetricSource(density, always)))


@final
class HeaterPower(AbstractHeatCandidate):
    """Lamps whose absorbed power is off by a share of it."""

    card: ClassVar[Card] = Card(
        "heater_power", "1", 0.3, -0.9, 10.0,
        excited_by="lamps",
        hides_behind="the capacity, the camera's scale",
        split_by="a run with a heater of known power",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | None = None

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with other powers."""
        del under
        factor = 1 + self.strength[0]
        return _lamps(model, lambda lamp: replace(lamp, power=factor * lamp.power))


@final
class HeaterLag(AbstractHeatCandidate):
    """Lamps that warm up and cool down more slowly than stated.

    What they give lags behind what is stated, of first order with the strength as time constant.
    """

    card: ClassVar[Card] = Card(
        "heater_lag", "s", 3.0, 0.0, 60.0,
        excited_by="lamps that are switched",
        hides_behind="a slow sensor, a clock that is off",
        split_by="the lamp's light logged",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | None = None

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with slower lamps."""
        del under

        def slower(lamp: Heating) -> Heating:
            rise = lamp.schedule.rise + self.strength[0]
            return replace(lamp, schedule=replace(lamp.schedule, rise=rise))

        return _lamps(model, slower)


@final
class InDepthAbsorption(AbstractHeatCandidate):
    """Lamps of which a share is absorbed below the surface, as exp(-depth / size) / size.

    One part for each depth, which is the size of its place.

    Source: Modest, Radiative Heat Transfer (2013), section 10.4, Beer's law.
    """

    card: ClassVar[Card] = Card(
        "in_depth_absorption", "1", 1.0, 0.0, 1.0,
        excited_by="lamps on poor conductors",
        hides_behind="a conductivity that changes with temperature",
        split_by="a run with the surface blackened",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with light that reaches below the surface."""
        space, mesh = model.space, model.space.mesh
        middle = jnp.asarray(mesh.nodes[mesh.faces[:, :3]].mean(1))[space.skin]
        way = jnp.asarray(mesh.nodes[mesh.cells[:, :4]].mean(1)) - middle
        below = jnp.abs(jnp.sum(way * jnp.asarray(mesh.normals)[space.skin], -1))
        lit = jnp.mean(under.profile, 1)[space.skin]
        volume = jnp.asarray(model.space.volume)
        shapes = lit * jnp.exp(-below / self.place.size[:, None])
        total = shapes @ volume
        density = (self.strength / jnp.where(total > 0, total, 1.0)) @ shapes
        sources = tuple(
            VolumetricSource(lamp.power * density, lamp.schedule)
            for lamp in model.surface
            if isinstance(lamp, Heating)
        )
        less = _lamps(
            model, lambda lamp: replace(lamp, power=(1 - self.strength.sum()) * lamp.power)
        )
        return replace(less, volume=(*model.volume, *sources))
