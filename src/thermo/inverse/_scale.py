"""Factors on what a run was told: the lamp's power, the camera's scale."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final, final

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float

from thermo._compiled import program
from thermo.inverse._case import Case
from thermo.inverse._objective import Objective, Parameters, data_residual, start
from thermo.physics import ForwardOnly


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


def _scaled(case: Case, logs: Mapping[str, Float[Array, ""]]) -> Case:
    power = case.under.power * jnp.exp(logs.get("heater_power", jnp.zeros(())))
    return replace(case, under=replace(case.under, power=power))


def _seen(
    objective: Objective, parameters: Parameters, case: Case, logs: Mapping[str, Float[Array, ""]]
) -> Float[Array, " values"]:
    """Residual of one run in kelvin [K], with logarithms of factors [1]."""
    apart = data_residual(objective, parameters, _scaled(case, logs), ForwardOnly())
    if "camera_emissivity" not in logs:
        return apart
    # What is read above the temperature that the body reflects, with the factor on it.
    above = apart + ((case.data - case.under.surroundings) * case.used).ravel()
    return apart + jnp.expm1(logs["camera_emissivity"]) * above


@program
def scaled_slopes(objective: Objective, names: tuple[str, ...]) -> Float[Array, "values unknowns"]:
    """Slopes of all readings by the parameters and by logarithms of factors [K].

    Arguments: `objective`: its errors of 1 K each (`in_kelvin`), its fields where they stand;
    `names`: of factors. All directions share one pass through each run.
    """
    flat, unravel = ravel_pytree(start(objective))
    size = len(flat)
    here = jnp.concatenate([flat, jnp.zeros(len(names))])

    def read(point: Float[Array, " unknowns"], case: Case) -> Float[Array, " values"]:
        logs = dict(zip(names, point[size:], strict=True))
        return _seen(objective, unravel(point[:size]), case, logs)

    def slopes(case: Case) -> Float[Array, "values unknowns"]:
        def along(way: Float[Array, " unknowns"]) -> Float[Array, " values"]:
            return jax.jvp(lambda point: read(point, case), (here,), (way,))[1]

        return jax.vmap(along, out_axes=1)(jnp.eye(len(here)))

    parts = [jax.lax.map(slopes, case) for case in objective.cases]
    return jnp.concatenate([part.reshape(-1, len(here)) for part in parts])
