"""When a source is on, and histories given at points in time."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax
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
        time = jnp.asarray(time)
        # All points are compared at once, where `jnp.interp` would bisect: XLA (seen with JAX
        # 0.11) does not compile a bisection within a loop over steps for a GPU.
        after = jnp.searchsorted(self.time, time, side="right", method="compare_all")
        last = self.time.size - 1
        after = jnp.clip(after, min(1, last), last)
        begin, end = self.time[after - 1], self.time[after]
        share = (time - begin) / jnp.where(end > begin, end - begin, 1.0)
        within = self.value[after - 1] + share * (self.value[after] - self.value[after - 1])
        within = jnp.where(time < self.time[0], self.value[0], within)
        return jnp.where(time > self.time[-1], self.value[-1], within)


@final
class Schedule(eqx.Module):
    """A source that is on for 0 <= t < `until`, warming up and cooling down with `rise`.

    s(t) = 1 - exp(-t / rise) while on, then s(until) exp(-(t - until) / rise); a rise of zero
    switches at once. With a course s(t) is multiplied by it.

    - `until`: [s]; `rise`: [s]; `course`: share of the power that was logged [1], or None.
    - `pulse`: by a rise shorter than this [s] the slope is taken as by one of this. The exact slope
      by a rise of zero is an impulse at each switch, which falls between steps; a pulse as long as
      a few steps takes as much heat away.

    Source: the scene format, key `heater`.
    """

    until: float | Float[Array, ""]
    rise: float | Float[Array, ""] = 0.0
    course: History | None = None
    pulse: float | Float[Array, ""] = 0.0

    def share(self, time: Time) -> Float[Array, ""]:
        """Share of the full power [1] at a time [s]."""
        time = jnp.asarray(time)
        rise, pulse = jnp.asarray(self.rise, float), jnp.asarray(self.pulse, float)
        on = (time >= 0) & (time < self.until)
        exact = jnp.where(rise > 0, self._slow(time, rise), jnp.where(on, 1.0, 0.0))
        # Of no value, with the slope by a rise that is as long as the pulse.
        longer = jax.lax.stop_gradient(jnp.maximum(pulse - rise, 0.0))
        near = self._slow(time, rise + longer)
        sudden = jax.lax.stop_gradient(exact - near) + near
        share = jnp.where(rise < pulse, sudden, exact)
        return share if self.course is None else share * self.course.at(time)

    def _slow(self, time: Float[Array, ""], rise: Float[Array, ""]) -> Float[Array, ""]:
        # The divisor stays positive where the rise is zero, so that derivatives stay finite.
        divisor = jnp.where(rise > 0, rise, 1.0)
        warm = 1 - jnp.exp(-jnp.clip(time, 0.0, self.until) / divisor)
        cooling = jnp.exp(-jnp.maximum(time - self.until, 0.0) / divisor)
        return jnp.where(time >= 0, warm * cooling, 0.0)


def value_at(level: Float[Array, ""] | float | History, time: Time) -> Float[Array, ""]:
    """A constant, or a history read at a time [s]."""
    return level.at(time) if isinstance(level, History) else jnp.asarray(level)
