"""Fields: a quantity over the object, from a few unconstrained numbers."""

from __future__ import annotations

from abc import abstractmethod

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, PyTree

from thermo.fields._extension import Extension
from thermo.fields._quantity import Quantity


class AbstractField(eqx.Module):
    """A quantity over the object.

    `parameters` are dimensionless and unconstrained, of order one; values are physical.
    """

    quantity: eqx.AbstractVar[Quantity]

    @abstractmethod
    def parameters(self) -> PyTree[Float[Array, "..."]]:
        """What an optimiser changes [1]."""

    @abstractmethod
    def with_parameters(self, parameters: PyTree[Float[Array, "..."]]) -> AbstractField:
        """The same field with other parameters [1]."""

    @abstractmethod
    def control_values(self) -> Float[Array, " controls"]:
        """Physical values at the controls, in the quantity's unit."""

    @abstractmethod
    def smooth_values(self) -> Float[Array, " controls"]:
        """What neighbouring controls have nearly in common [1], for a prior on smoothness."""

    @abstractmethod
    def cell_values(self) -> Float[Array, " cells"]:
        """Values in the cells, in the quantity's unit."""

    @abstractmethod
    def face_values(self) -> Float[Array, " faces"]:
        """Values on the boundary faces, in the quantity's unit."""


class AbstractExtendedField(AbstractField):
    """A field whose values at its controls an extension carries to faces and cells, linearly."""

    extension: eqx.AbstractVar[Extension]

    def smooth_values(self) -> Float[Array, " controls"]:
        """log(phi) at the controls [1]."""
        return jnp.log(self.control_values())

    def cell_values(self) -> Float[Array, " cells"]:
        """Values in the cells, in the quantity's unit."""
        return self.extension.to_cells(self.control_values())

    def face_values(self) -> Float[Array, " faces"]:
        """Values on the boundary faces, in the quantity's unit."""
        return self.extension.to_faces(self.control_values())
