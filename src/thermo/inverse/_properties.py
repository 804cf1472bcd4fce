"""From stated values and fields to the properties of a body."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.errors import InputError
from thermo.observe import Scene, TemperatureTable
from thermo.physics.effects import TabulatedLaw


@final
class Properties(eqx.Module):
    """What the heat equation needs of a body.

    - `conductivity` (cells,) [W/m/K]; `capacity` (cells,) [J/m3/K].
    - `convection` (faces,) [W/m2/K]; `emissivity` (faces,) [1].
    - `conductivity_law`, `capacity_law`: how they change with temperature, one at `REFERENCE` [1];
      None where they do not.
    """

    conductivity: Float[Array, " cells"]
    capacity: Float[Array, " cells"]
    convection: Float[Array, " faces"]
    emissivity: Float[Array, " faces"]
    conductivity_law: TabulatedLaw | None = None
    capacity_law: TabulatedLaw | None = None


@final
class Stated(eqx.Module):
    """Uniform values that a scene states, or that stand in for what is unknown.

    - `conductivity` [W/m/K]; `capacity` [J/m3/K]; `convection` [W/m2/K]; `emissivity` [1].
    - `conductivity_law`, `capacity_law`: as of `Properties`.
    """

    conductivity: float
    capacity: float
    convection: float
    emissivity: float
    conductivity_law: TabulatedLaw | None = None
    capacity_law: TabulatedLaw | None = None

    def of(self, quantity: str) -> float:
        """Value of any quantity that a fit can take, in that quantity's SI unit."""
        ratio = {
            "conductivity": self.conductivity,
            "diffusivity": self.conductivity / self.capacity,
            "volumetric_heat_capacity": self.capacity,
            "convection": self.convection,
            "emissivity": self.emissivity,
            "scaled_convection": self.convection / self.capacity,
            "scaled_emissivity": self.emissivity / self.capacity,
        }
        return ratio[quantity]


_CLASHES = (
    ("conductivity", "diffusivity"),
    ("convection", "scaled_convection"),
    ("emissivity", "scaled_emissivity"),
)


def law_of(stated: float | TemperatureTable | None) -> TabulatedLaw | None:
    """How a property changes with temperature [1], where a table states it."""
    if not isinstance(stated, TemperatureTable):
        return None
    share = np.asarray(stated.value) / stated.at()
    return TabulatedLaw(jnp.asarray(stated.temperature), jnp.asarray(share))


def check_unknowns(unknown: tuple[str, ...], scene: Scene, given: Collection[str] = ()) -> None:
    """Refuse unknowns that are two names of one property, and properties [1] left without a value.

    `given` names quantities that have a value from elsewhere than the scene. Raises `InputError`.
    """
    for pair in _CLASHES:
        if set(pair) <= set(unknown):
            raise InputError(
                "two unknowns describe the same property",
                where="unknown",
                value=", ".join(pair),
                limit="one of the two",
                remedy=f"leave out {pair[0]} or {pair[1]}",
            )
    stated = {
        "conductivity": scene.material.conductivity,
        "convection": scene.convection,
        "emissivity": scene.emissivity,
    }
    for (name, other), value in zip(_CLASHES, stated.values(), strict=True):
        if value is None and not {name, other} & {*unknown, *given}:
            raise InputError(
                f"{name} is neither stated nor unknown",
                where=f"{scene.folder}/scene.json: {name}",
                value="null",
                limit="a value, or the name among the unknowns",
                remedy=f"state it there, give initial.{name}=VALUE, or add it to unknown=[...]",
            )


Values = tuple[Float[Array | np.ndarray, " cells"], Float[Array | np.ndarray, " faces"]]
"""A quantity in the cells and on the faces, in its unit."""


def properties(stated: Stated, values: Mapping[str, Values], cells: int, faces: int) -> Properties:
    """Properties of the body, with quantities that vary in place of stated values.

    Arguments:

    - `stated`: uniform values [SI]; `values`: by quantity name, in cells and on faces.
    - `cells`, `faces`: their numbers [1].

    Diffusivity is k = alpha rho c at the capacity in force; scaled quantities likewise, h = beta
    rho c and eps = gamma rho c with the stated capacity.

    Source: paper, appendix B.2 (checklist B3).
    """

    def inside(name: str, other: float) -> Float[Array, " cells"]:
        return jnp.asarray(values[name][0]) if name in values else jnp.full(cells, other)

    def outside(name: str, other: float) -> Float[Array, " faces"]:
        return jnp.asarray(values[name][1]) if name in values else jnp.full(faces, other)

    capacity = inside("volumetric_heat_capacity", stated.capacity)
    conductivity = inside("conductivity", stated.conductivity)
    if "diffusivity" in values:
        conductivity = inside("diffusivity", 0.0) * capacity
    convection = outside("convection", stated.convection)
    if "scaled_convection" in values:
        convection = outside("scaled_convection", 0.0) * stated.capacity
    emissivity = outside("emissivity", stated.emissivity)
    if "scaled_emissivity" in values:
        emissivity = outside("scaled_emissivity", 0.0) * stated.capacity
    laws = stated.conductivity_law, stated.capacity_law
    return Properties(conductivity, capacity, convection, emissivity, *laws)


def diffusivity_quantile(
    stated: Stated, values: Mapping[str, Values], cells: int, quantile: float
) -> float:
    """The diffusivity [m2/s] that a share `quantile` of the cells is at or below.

    Arguments as for `properties`.
    """
    # What varies over the faces has no part in it.
    inside = {name: (held, np.zeros(0)) for name, (held, _) in values.items()}
    body = properties(stated, inside, cells, 0)
    return float(jnp.quantile(body.conductivity / body.capacity, quantile))
