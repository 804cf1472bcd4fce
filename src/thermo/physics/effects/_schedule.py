"""When a source is on, and histories given at points in time."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.physics.effects._effect import Time


@final
class Schedule(eqx.Module):
    """A source that is on for 0 <= t < `until`, warming up and cooling down with `rise`.

    s(t) = 1 - exp(-t / rise) while on, then s(until) exp(-(t - until) / rise); a rise of zero
    switches at once.

    - `until`: [s]; `rise`: [s].

    Source: the scene format, key `heater`.
    """

    until: float | Float[Array, ""]
    rise: float | Float[Array, ""] = 0.0

    def share(self, time: Time) -> Float[Array, ""]:
        """Share of the full power [1] at a time [s]."""
        time = jnp.asarray(time)
        rise = jnp.asarray(self.rise)
        on = (time >= 0) & (time < self.until)
        # The divisor stays positive where the rise is zero, so that derivatives stay finite.
        divisor = jnp.where(rise > 0, rise, 1.0)
        warm = 1 - jnp.exp(-jnp.clip(time, 0.0, self.until) / divisor)
        cooling = jnp.exp(-jnp.maximum(time - self.until, 0.0) / divisor)
        slow = jnp.where(time >= 0, warm * cooling, 0.0)
        return jnp.where(rise > 0, slow, jnp.where(on, 1.0, 0.0))


@final
class History(eqx.Module):
    """A quantity that runs linearly between given points in time and is constant outside them.

    - `time`: (points,) [s], increasing; `value`: (points,), e.g. [K].
    """

    time: Float[Array, " points"]
    value: Float[Array, " points"]

    def at(self, time: Time) -> Float[Array, ""]:
        """Value at a time [s], in the unit of `value`, e.g. [K]."""
        return jnp.interp(jnp.asarray(time), self.time, self.value)


def value_at(level: Float[Array, ""] | float | History, time: Time) -> Float[Array, ""]:
    """A constant, or a history read at a time [s]."""
    return level.at(time) if isinstance(level, History) else jnp.asarray(level)
