"""What may be added to the stated model of a run: heat that is missing, or a camera that errs."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo._compiled import program
from thermo.inverse._conditions import Conditions
from thermo.physics import Model


class AbstractHeatAddition(eqx.Module):
    """An effect on the heat equation of a body."""

    @abstractmethod
    def to_model(self, model: Model, under: Conditions) -> Model:
        """The model [SI] with the effect in it, under a run's conditions [K, W]."""


class AbstractReadingAddition(eqx.Module):
    """An effect on what is read of a body's temperatures."""

    @abstractmethod
    def to_readings(
        self,
        temperature: Float[Array, "frames samples"],
        time: Float[Array, " frames"],
        under: Conditions,
    ) -> Float[Array, "frames samples"]:
        """What is read [K] of temperatures [K] at times [s], under a run's conditions [K, W]."""


Addition = AbstractHeatAddition | AbstractReadingAddition
"""What may be added to the model of a run."""


def extend(model: Model, under: Conditions, additions: Iterable[Addition]) -> Model:
    """The model [SI] with all additions to the heat equation in it, in their order."""
    for one in additions:
        if isinstance(one, AbstractHeatAddition):
            model = one.to_model(model, under)
    return model


def read_as(
    temperature: Float[Array, "frames samples"],
    time: Float[Array, " frames"],
    under: Conditions,
    pinned: Float[Array, "*samples"],
    additions: Iterable[Addition],
) -> Float[Array, "frames samples"]:
    """What is read [K] of a body's temperatures [K] at times [s] with all additions to that.

    Where `pinned` is 1 and not 0 [1], a sample's constant error was taken off by its quiet frames,
    and with it what an addition does to the body before the run.
    """
    for one in additions:
        if isinstance(one, AbstractReadingAddition):
            quiet = jnp.full((2, temperature.shape[1]), under.initial)
            before = one.to_readings(quiet, jnp.array([-1.0, 0.0]), under)[0] - under.initial
            temperature = one.to_readings(temperature, time, under) - pinned * before
    return temperature


@program
def read_now(
    temperature: Float[Array, "frames samples"],
    time: Float[Array, " frames"],
    under: Conditions,
    pinned: Float[Array, "*samples"],
    additions: tuple[Addition, ...],
) -> Float[Array, "frames samples"]:
    """`read_as` where no program is traced: in one of its own, not one for each operation [K]."""
    return read_as(temperature, time, under, pinned, additions)


def read_at_rest(
    under: Conditions, samples: int, additions: Iterable[Addition]
) -> Float[Array, " samples"]:
    """What `samples` [1] of a body at rest before a run read more than it is at [K].

    Of all additions to the readings, each after the other.
    """
    quiet = jnp.full((2, samples), under.initial)
    for one in additions:
        if isinstance(one, AbstractReadingAddition):
            quiet = one.to_readings(quiet, jnp.array([-1.0, 0.0]), under)
    return quiet[0] - under.initial
