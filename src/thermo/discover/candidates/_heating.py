"""Effects on how heat comes in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar, final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.discover._candidate import FINE, AbstractHeatCandidate, Card, Inclusion, Place
from thermo.inverse import Conditions
from thermo.physics import Model, VolumeRule, volume_rule
from thermo.physics.effects import Heating, NodalSource, Schedule


def _lamps(model: Model, change: Callable[[Heating], Heating]) -> Model:
    surface = tuple(change(one) if isinstance(one, Heating) else one for one in model.surface)
    return replace(model, surface=surface)


def _released(
    rule: VolumeRule, shapes: Float[Array, "parts points cells"], power: Float[Array, " parts"]
) -> Float[Array, "points cells"]:
    """Density [W/m3] of heat released as each shape [1], so that its integral is its power [W]."""
    whole = jnp.einsum("pqc,qc->p", shapes, rule.weight)
    return jnp.tensordot(power / jnp.where(whole > 0, whole, 1.0), shapes, 1)


@final
class HiddenSource(AbstractHeatCandidate):
    """Heat released inside, its density as exp(-r^2 / (2 size^2)), all the time.

    Or even within a body that has an edge, an `Inclusion`.
    """

    card: ClassVar[Card] = Card(
        "hidden_source", "W", 5.0, -np.inf, np.inf,
        excited_by="any run, best without a lamp",
        hides_behind="contact, the lamp's power",
        split_by="a run without a lamp that starts as warm as the surroundings",
        means="heat released inside, taken up where it is negative",
        edged=True,
        total=True,
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | Inclusion

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with sources in it."""
        del under
        always = Schedule(jnp.asarray(1e12), jnp.asarray(0.0))
        rule = volume_rule(model.space, FINE if isinstance(self.place, Inclusion) else 2)
        rate = rule.load(_released(rule, self.place.shapes(rule.at), self.strength))
        return replace(model, volume=(*model.volume, NodalSource(rate, always)))


@final
class HeaterPower(AbstractHeatCandidate):
    """Lamps whose absorbed power is off by a share of it."""

    card: ClassVar[Card] = Card(
        "heater_power", "1", 0.3, -0.9, 10.0,
        excited_by="lamps",
        hides_behind="the capacity, the camera's scale",
        split_by="a run with a heater of known power",
        means="share by which the lamps are stronger",
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

    - `pulse`: [s], by a lag shorter than this the slope is taken as by one of this.
    """

    card: ClassVar[Card] = Card(
        "heater_lag", "s", 3.0, 0.0, 60.0,
        excited_by="lamps that are switched",
        hides_behind="a slow sensor, a clock that is off",
        split_by="the lamp's light logged",
        means="time constant of lamps that warm up and cool down, beyond the stated one",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    pulse: Float[Array, ""] = eqx.field(kw_only=True)
    place: Place | None = None

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with slower lamps."""
        del under

        def slower(lamp: Heating) -> Heating:
            rise = lamp.schedule.rise + self.strength[0]
            return replace(lamp, schedule=replace(lamp.schedule, rise=rise, pulse=self.pulse))

        return _lamps(model, slower)


@final
class InDepthAbsorption(AbstractHeatCandidate):
    """Lamps of which a share is absorbed below the surface, as exp(-depth / size) / size.

    The depth is measured along the light, which goes straight on within the body. One part for each
    size, which is that of its place.

    Source: Modest, Radiative Heat Transfer (2013), section 10.4, Beer's law.
    """

    card: ClassVar[Card] = Card(
        "in_depth_absorption", "1", 1.0, 0.0, 1.0,
        excited_by="lamps on poor conductors",
        hides_behind="a conductivity that changes with temperature",
        split_by="a run with the surface blackened",
        means="share of the lamps' light that is absorbed below the surface",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place

    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with light that reaches below the surface."""
        rule = volume_rule(model.space, FINE)
        shapes = jnp.exp(-under.path.below(rule.at) / self.place.size[:, None, None])
        rate = rule.load(_released(rule, under.path.light(rule.at) * shapes, self.strength))
        sources = tuple(
            NodalSource(lamp.power * rate, lamp.schedule)
            for lamp in model.surface
            if isinstance(lamp, Heating)
        )
        less = _lamps(
            model, lambda lamp: replace(lamp, power=(1 - self.strength.sum()) * lamp.power)
        )
        return replace(less, volume=(*model.volume, *sources))
