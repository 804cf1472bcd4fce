"""Effects on what is read: a slow sensor, a clock that is off, a camera's scale."""

from __future__ import annotations

from typing import ClassVar, final

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.discover._candidate import AbstractReadingCandidate, Card, Place
from thermo.discover.candidates._between_frames import between_frames
from thermo.inverse import Conditions


@final
class SensorLag(AbstractReadingCandidate):
    """A sensor of first order: tau dy/dt = T - y, begun at the first temperature.

    Temperatures run linearly from frame to frame, for which the answer is exact.

    Source: Doebelin, Measurement Systems (2003), section 3.3.
    """

    card: ClassVar[Card] = Card(
        "sensor_lag", "s", 2.0, 0.0, 60.0,
        excited_by="fast changes",
        hides_behind="a lamp that warms up slowly, long time steps",
        split_by="a run in which a shutter opens at a known time",
        means="time constant of the sensor",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | None = None

    def to_readings(
        self,
        temperature: Float[Array, "frames samples"],
        time: Float[Array, " frames"],
        under: Conditions,
    ) -> Float[Array, "frames samples"]:
        """What is read [K] of temperatures [K] at times [s]."""
        del under
        size = jnp.diff(time)
        # A lag far below a frame's distance reads as the temperature less lag times slope.
        lag = jnp.maximum(self.strength[0], 0.0)
        safe = jnp.where(lag > 1e-6, lag, 1.0)
        ratio = jnp.where(size > 0, size, 1.0) / safe
        kept = jnp.where(lag > 1e-6, jnp.exp(-ratio), 0.0)
        # What is left of the sensor's error after a frame, and what the slope adds to it.
        slope = jnp.diff(temperature, axis=0) / jnp.where(size > 0, size, 1.0)[:, None]

        def step(error: Float[Array, " samples"], frame: tuple[Array, ...]) -> tuple[Array, Array]:
            share, rate = frame
            after = share * error - self.strength[0] * (1 - share) * rate
            return after, after

        _, errors = jax.lax.scan(step, jnp.zeros(temperature.shape[1]), (kept, slope))
        return temperature + jnp.concatenate([jnp.zeros((1, temperature.shape[1])), errors])


@final
class ClockOffset(AbstractReadingCandidate):
    """Frames taken later than their stamp says, T(t + offset)."""

    card: ClassVar[Card] = Card(
        "clock_offset", "s", 2.0, -10.0, 10.0,
        excited_by="fast changes",
        hides_behind="a slow sensor, a lamp that warms up slowly",
        split_by="a run in which a shutter opens at a known time",
        means="how much later frames are than their stamps",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | None = None

    def to_readings(
        self,
        temperature: Float[Array, "frames samples"],
        time: Float[Array, " frames"],
        under: Conditions,
    ) -> Float[Array, "frames samples"]:
        """What is read [K] of temperatures [K] at times [s]."""
        del under
        return between_frames(temperature, time, time + self.strength[0])


@final
class CameraEmissivity(AbstractReadingCandidate):
    """A camera told a wrong emissivity: it reads (1 + gamma) (T - T_reflected) above that.

    Source: Vollmer and Moellmann, Infrared Thermal Imaging (2018), section 3.2.
    """

    card: ClassVar[Card] = Card(
        "camera_emissivity", "1", 0.2, -0.9, 2.0,
        excited_by="a temperature that is known otherwise",
        hides_behind="the lamp's power, where the body starts at the reflected temperature",
        split_by="a patch of known emissivity, or a known hot start",
        means="share by which is read more above the reflected temperature",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | None = None

    def to_readings(
        self,
        temperature: Float[Array, "frames samples"],
        time: Float[Array, " frames"],
        under: Conditions,
    ) -> Float[Array, "frames samples"]:
        """What is read [K] of temperatures [K] at times [s]."""
        del time
        return temperature + self.strength[0] * (temperature - under.surroundings)


@final
class CameraDrift(AbstractReadingCandidate):
    """A camera that reads more and more, strength times t, in every run alike.

    Source: Vollmer and Moellmann, Infrared Thermal Imaging (2018), section 2.4, drift of a camera
    between two looks at its shutter.
    """

    card: ClassVar[Card] = Card(
        "camera_drift", "K/s", 0.01, -1.0, 1.0,
        excited_by="long runs",
        hides_behind="a source as wide as the body, surroundings that drift",
        split_by="a body of known temperature in view",
        fault=True,
        means="how much more is read with each second",
    )  # fmt: skip
    strength: Float[Array, " parts"]
    place: Place | None = None

    def to_readings(
        self,
        temperature: Float[Array, "frames samples"],
        time: Float[Array, " frames"],
        under: Conditions,
    ) -> Float[Array, "frames samples"]:
        """What is read [K] of temperatures [K] at times [s]."""
        del under
        return temperature + self.strength[0] * jnp.maximum(time, 0.0)[:, None]
