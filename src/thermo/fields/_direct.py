"""Fields whose parameters are the values themselves: uniform, patchwise, on control points."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.fields._extension import (
    Extension,
    interpolating_extension,
    patch_extension,
    uniform_extension,
)
from thermo.fields._field import AbstractExtendedField
from thermo.fields._head import AbstractHead
from thermo.fields._quantity import Quantity
from thermo.fields._surface_graph import ControlPoints
from thermo.mesh import Mesh


@final
class DirectField(AbstractExtendedField):
    """One value a control, phi_i = head(u_i).

    - `raw`: u, (controls,) [1]; `head`: the map to physical values.
    """

    quantity: Quantity = eqx.field(static=True)
    extension: Extension
    head: AbstractHead
    raw: Float[Array, " controls"]

    def parameters(self) -> Float[Array, " controls"]:
        """u [1]."""
        return self.raw

    def with_parameters(self, parameters: Float[Array, " controls"]) -> DirectField:
        """The same field with other u [1]."""
        return eqx.tree_at(lambda field: field.raw, self, parameters)

    def control_values(self) -> Float[Array, " controls"]:
        """Physical values at the controls, in the quantity's unit."""
        return self.head.value(self.raw)


def _direct(
    quantity: Quantity, extension: Extension, head: AbstractHead, initial: float, count: int
) -> DirectField:
    # Not a weak type: a fit would be compiled a second time after its first step.
    raw = jnp.full(count, head.raw(jnp.asarray(initial, float)))
    return DirectField(quantity, extension, head, raw)


def uniform_field(
    quantity: Quantity, mesh: Mesh, head: AbstractHead, initial: float
) -> DirectField:
    """One value for the whole object, `initial` in the quantity's unit."""
    return _direct(quantity, uniform_extension(mesh), head, initial, 1)


def patchwise_field(
    quantity: Quantity, mesh: Mesh, head: AbstractHead, initial: float, controls: ControlPoints
) -> DirectField:
    """One value a patch, `initial` in the quantity's unit; a patch is what is nearest a control."""
    extension = patch_extension(mesh, controls)
    return _direct(quantity, extension, head, initial, len(controls.vertex))


def control_point_field(
    quantity: Quantity, mesh: Mesh, head: AbstractHead, initial: float, controls: ControlPoints
) -> DirectField:
    """Values on control points, `initial` in the quantity's unit, interpolated in between."""
    extension = interpolating_extension(mesh, controls)
    return _direct(quantity, extension, head, initial, len(controls.vertex))
