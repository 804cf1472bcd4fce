"""Factors on what a run was told: the lamp's power, the camera's scale."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final, final

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.inverse._case import Case
from thermo.inverse._objective import Objective, case_temperatures


@final
class Scale(eqx.Module):
    """A factor, 1 where all is as stated, with the bounds of what is plausible [1]."""

    lower: float = eqx.field(static=True, default=0.1)
    upper: float = eqx.field(static=True, default=10.0)


SCALES: Final[Mapping[str, Scale]] = MappingProxyType(
    {"heater_power": Scale(), "camera_emissivity": Scale()}
)
"""Factors that may be wrong beside the body's own unknowns, by name: on the absorbed power of all
lamps, and on what the camera reads above the temperature that the body reflects."""


def _read(
    objective: Objective, case: Case, name: str, factor: Float[Array, ""]
) -> Float[Array, "frames samples"]:
    if name == "heater_power":
        under = replace(case.under, power=factor * case.under.power)
        return case_temperatures(objective, objective.fields, replace(case, under=under))
    reflected = case.under.surroundings
    found = case_temperatures(objective, objective.fields, case)
    return reflected + factor * (found - reflected)


@eqx.filter_jit
def scale_slopes(objective: Objective, name: str) -> Float[Array, " values"]:
    """Derivative of all readings by the logarithm of a factor [K], in the order of the residual."""

    def slope(case: Case) -> Float[Array, "frames samples"]:
        one = jnp.ones(())
        _, change = jax.jvp(lambda factor: _read(objective, case, name, factor), (one,), (one,))
        return change * case.used

    return jnp.concatenate([jax.lax.map(slope, case).ravel() for case in objective.cases])
