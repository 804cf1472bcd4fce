"""Fields: a quantity over the object, from a few unconstrained numbers."""

from __future__ import annotations

from abc import abstractmethod

import equinox as eqx
from jaxtyping import Array, Float, PyTree

from thermo.fields._extension import Extension
from thermo.fields._quantity import Quantity


class AbstractField(eqx.Module):
    """A quantity over the object.

    `parameters` are dimensionless and unconstrained, of order one; values are physical.
    """

    quantity: eqx.AbstractVar[Quantity]
    extension: eqx.AbstractVar[Extension]

    @abstractmethod
    def parameters(self) -> PyTree[Float[Array, "..."]]:
        """What an optimiser changes [1]."""

    @abstractmethod
    def with_parameters(self, parameters: PyTree[Float[Array, "..."]]) -> AbstractField:
        """The same field with other parameters [1]."""

    @abstractmethod
    def control_values(self) -> Float[Array, " controls"]:
        """Physical values at the controls, in the quantity's unit."""


def cell_values(field: AbstractField) -> Float[Array, " cells"]:
    """Values of a field in the cells, in its quantity's unit."""
    return field.extension.to_cells(field.control_values())


def face_values(field: AbstractField) -> Float[Array, " faces"]:
    """Values of a field on the boundary faces, in its quantity's unit."""
    return field.extension.to_faces(field.control_values())
