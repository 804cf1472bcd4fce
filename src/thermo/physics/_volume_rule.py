"""Integrals over the cells of what is given at points."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from thermo.physics._discretisation import Discretisation
from thermo.physics._quadrature import tetrahedron_rule
from thermo.physics._shape import cell_shape


@final
class VolumeRule(eqx.Module):
    """Points in every cell.

    - `at`: (points, cells, 3) [m]; `weight`: (points, cells) [m3].
    - `shape`: of a cell's nodes at its points, (points, corners) [1]; `cells`: those nodes.
    - `nodes`: how many there are in all [1].
    """

    at: Float[Array, "points cells 3"]
    weight: Float[Array, "points cells"]
    shape: Float[Array, "points corners"]
    cells: Int[Array, "cells corners"]
    nodes: int = eqx.field(static=True)

    def load(self, density: Float[Array, "points cells"]) -> Float[Array, " nodes"]:
        """Nodal heat rate [W] of a power density at the points [W/m3], integral of q N_i.

        Where a cell releases its heat is kept to first order, however unevenly it does.
        """
        terms = jnp.einsum("qi,qc->ci", self.shape, density * self.weight)
        return jnp.zeros(self.nodes).at[self.cells].add(terms)


def volume_rule(space: Discretisation, degree: int) -> VolumeRule:
    """Points of a body whose integrals are exact for polynomials to a degree [1]."""
    points, weights = tetrahedron_rule(degree)
    mesh = space.mesh
    corners = jnp.asarray(mesh.nodes)[jnp.asarray(mesh.cells)[:, :4]]
    return VolumeRule(
        jnp.einsum("qa,cax->qcx", points, corners),
        jnp.asarray(weights)[:, None] * jnp.asarray(space.volume),
        jnp.asarray(cell_shape(points, space.order)),
        jnp.asarray(mesh.cells),
        len(mesh.nodes),
    )
