"""A field that departs from a given one by a smooth factor."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.spatial import KDTree

from thermo.fields._extension import Extension, interpolating_extension
from thermo.fields._field import AbstractField
from thermo.fields._quantity import Quantity
from thermo.fields._surface_graph import ControlPoints
from thermo.mesh import Mesh


@final
class DepartingField(AbstractField):
    """phi = phi_0 exp(E d): the logarithm departs by d at the controls, and E carries it on.

    - `cells`, `faces`, `controls`: phi_0 there, in the quantity's unit.
    - `departure`: d, (controls,) [1]; zero is phi_0 itself, however that was made.
    """

    quantity: Quantity = eqx.field(static=True)
    extension: Extension
    cells: Float[Array, " cells"]
    faces: Float[Array, " faces"]
    controls: Float[Array, " controls"]
    departure: Float[Array, " controls"]

    def parameters(self) -> Float[Array, " controls"]:
        """d [1]."""
        return self.departure

    def with_parameters(self, parameters: Float[Array, " controls"]) -> DepartingField:
        """The same field with another d [1]."""
        return eqx.tree_at(lambda field: field.departure, self, parameters)

    def control_values(self) -> Float[Array, " controls"]:
        """Physical values at the controls, in the quantity's unit."""
        return self.controls * jnp.exp(self.departure)

    def smooth_values(self) -> Float[Array, " controls"]:
        """log(phi) at the controls [1]."""
        return jnp.log(self.controls) + self.departure

    def cell_values(self) -> Float[Array, " cells"]:
        """Values in the cells, in the quantity's unit."""
        return self.cells * jnp.exp(self.extension.to_cells(self.departure))

    def face_values(self) -> Float[Array, " faces"]:
        """Values on the boundary faces, in the quantity's unit."""
        return self.faces * jnp.exp(self.extension.to_faces(self.departure))


def departing_field(
    quantity: Quantity,
    mesh: Mesh,
    controls: ControlPoints,
    cells: Float[np.ndarray, " cells"],
    faces: Float[np.ndarray, " faces"],
) -> DepartingField:
    """A field at one that is given in `cells` and on `faces`, in the quantity's unit.

    The value of a control is that of the face nearest to it.
    """
    centres = mesh.nodes[mesh.faces[:, :3]].mean(1)
    _, near = KDTree(centres).query(controls.points)
    return DepartingField(
        quantity,
        interpolating_extension(mesh, controls),
        jnp.asarray(cells),
        jnp.asarray(faces),
        jnp.asarray(faces[near]),
        jnp.zeros(len(controls.points)),
    )
