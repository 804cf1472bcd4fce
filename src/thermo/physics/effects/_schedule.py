"""When a source is on, and histories given at points in time."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.physics.effects._effect import Time


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


@final
class Schedule(eqx.Module):
    """A source that is on for 0 <= t < `until`, warming up and cooling down with `rise`.

    s(t) = 1 - exp(-t / rise) while on, then s(until) exp(-(t - until) / rise); a rise of zero
    switches at once. With a course s(t) is multiplied by it.

    - `until`: [s]; `rise`: [s]; `course`: share of the power that was logged [1], or None.

    Source: the scene format, key `heater`.
    """

    until: float | Float[Array, ""]
    rise: float | Float[Array, ""] = 0.0
    course: History | None = None

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
        share = jnp.where(rise > 0, slow, jnp.where(on, 1.0, 0.0))
        return share if self.course is None else share * self.course.at(time)


def value_at(level: Float[Array, ""] | float | History, time: Time) -> Float[Array, ""]:
    """A constant, or a history read at a time [s]."""
    return level.at(time) if isinstance(level, History) else jnp.asarray(level)
