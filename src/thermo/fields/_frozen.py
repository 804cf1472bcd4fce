"""A field of which a part keeps its initial values."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, PyTree

from thermo.fields._extension import Extension
from thermo.fields._field import AbstractExtendedField
from thermo.fields._quantity import Quantity


@final
class FrozenField(AbstractExtendedField):
    """Another field whose controls under `frozen` stay at `kept`, bit for bit.

    - `inner`: the field; `frozen`: (controls,); `kept`: (controls,) in the quantity's unit.

    Source: paper, appendix B.5 (checklist C6).
    """

    quantity: Quantity = eqx.field(static=True)
    extension: Extension
    inner: AbstractExtendedField
    frozen: Bool[np.ndarray | Array, " controls"]
    kept: Float[np.ndarray | Array, " controls"]

    def parameters(self) -> PyTree[Float[Array, "..."]]:
        """The parameters of the inner field [1]."""
        return self.inner.parameters()

    def with_parameters(self, parameters: PyTree[Float[Array, "..."]]) -> FrozenField:
        """The same field with other parameters [1]."""
        inner = self.inner.with_parameters(parameters)
        return eqx.tree_at(lambda field: field.inner, self, inner)

    def control_values(self) -> Float[Array, " controls"]:
        """Physical values at the controls, in the quantity's unit."""
        return jnp.where(self.frozen, self.kept, self.inner.control_values())


def freeze(field: AbstractExtendedField, frozen: Bool[np.ndarray, " controls"]) -> FrozenField:
    """Keep the controls under `frozen` at their present values, in the quantity's unit."""
    return FrozenField(field.quantity, field.extension, field, frozen, field.control_values())
