"""Prescribed temperature on some nodes."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from thermo.physics.effects._effect import Time
from thermo.physics.effects._schedule import History


@final
class PrescribedTemperature(eqx.Module):
    """Patches whose temperature follows given histories.

    - `patch`: for each node the number of its history, or -1 where it is free, (nodes,).
    - `histories`: temperatures [K] over time [s].
    """

    patch: Int[Array, " nodes"]
    histories: tuple[History, ...]

    def free(self) -> Float[Array, " nodes"]:
        """One where a node is free, zero where it is prescribed [1]."""
        return jnp.where(self.patch < 0, 1.0, 0.0)

    def impose(self, temperature: Float[Array, " nodes"], time: Time) -> Float[Array, " nodes"]:
        """Temperatures [K] with the patches set to their histories at a time [s]."""
        for number, history in enumerate(self.histories):
            temperature = jnp.where(self.patch == number, history.at(time), temperature)
        return temperature
