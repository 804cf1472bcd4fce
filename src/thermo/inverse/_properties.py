"""From stated values and fields to the properties of a body."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import final

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.errors import InputError
from thermo.fields import AbstractField, cell_values, face_values
from thermo.observe import Scene


@final
class Properties(eqx.Module):
    """What the heat equation needs of a body.

    - `conductivity` (cells,) [W/m/K]; `capacity` (cells,) [J/m3/K].
    - `convection` (faces,) [W/m2/K]; `emissivity` (faces,) [1].
    """

    conductivity: Float[Array, " cells"]
    capacity: Float[Array, " cells"]
    convection: Float[Array, " faces"]
    emissivity: Float[Array, " faces"]


@final
class Stated(eqx.Module):
    """Uniform values that a scene states, or that stand in for what is unknown.

    - `conductivity` [W/m/K]; `capacity` [J/m3/K]; `convection` [W/m2/K]; `emissivity` [1].
    """

    conductivity: float
    capacity: float
    convection: float
    emissivity: float

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


def properties(
    stated: Stated, fields: Mapping[str, AbstractField], cells: int, faces: int
) -> Properties:
    """Properties of the body, with fields in place of stated values.

    Arguments:

    - `stated`: uniform values [SI]; `fields`: by quantity name.
    - `cells`, `faces`: their numbers [1].

    Diffusivity is k = alpha rho c at the capacity in force; scaled quantities likewise, h = beta
    rho c and eps = gamma rho c with the stated capacity.

    Source: paper, appendix B.2 (checklist B3).
    """
    capacity = jnp.full(cells, stated.capacity)
    if "volumetric_heat_capacity" in fields:
        capacity = cell_values(fields["volumetric_heat_capacity"])
    conductivity = jnp.full(cells, stated.conductivity)
    if "conductivity" in fields:
        conductivity = cell_values(fields["conductivity"])
    elif "diffusivity" in fields:
        conductivity = cell_values(fields["diffusivity"]) * capacity
    convection = jnp.full(faces, stated.convection)
    if "convection" in fields:
        convection = face_values(fields["convection"])
    elif "scaled_convection" in fields:
        convection = face_values(fields["scaled_convection"]) * stated.capacity
    emissivity = jnp.full(faces, stated.emissivity)
    if "emissivity" in fields:
        emissivity = face_values(fields["emissivity"])
    elif "scaled_emissivity" in fields:
        emissivity = face_values(fields["scaled_emissivity"]) * stated.capacity
    return Properties(conductivity, capacity, convection, emissivity)
