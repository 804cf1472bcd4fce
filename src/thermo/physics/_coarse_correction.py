"""What coarser spaces add to a preconditioner of a step's matrix.

Where heat crosses many cells in a step, as in metals, the diagonal alone lets conjugate gradients
carry it from cell to cell. Here what is smooth is met in coarser spaces as well, added up.

Source: Smith, Bjorstad and Gropp, Domain Decomposition, chapter 3, additive multilevel methods;
Bramble, Pasciak and Xu, Math. Comput. 55 (1990) 1.
"""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.scipy.linalg import cho_solve
from jaxtyping import Array, Bool, Float

from thermo.physics._coarse_spaces import CoarseSpaces
from thermo.physics._discretisation import Discretisation
from thermo.physics._shape import reference_mass
from thermo.physics.effects._effect import Time

WORTH = 20.0
"""Conducted over stored heat of a corner in a step [1], on average, from which it pays.

Linear cells take as long as without it there, quadratic ones a third less, where all cells are
alike; where some are much smaller than others neither gains (`benchmarks/coarse_spaces.py`).
"""


@final
class CoarseMatrices(eqx.Module):
    """M [J/K] and K [W/K] in the coarser spaces, made once for each simulation.

    - `stored`, `stiffness`: their diagonals at the corners, (corners,).
    - `stored_parts`, `stiffness_parts`: (parts, parts).
    - `rate`: conducted over stored heat of a corner, on average [1/s].
    """

    spaces: CoarseSpaces
    stored: Float[Array, " corners"]
    stiffness: Float[Array, " corners"]
    stored_parts: Float[Array, "parts parts"]
    stiffness_parts: Float[Array, "parts parts"]
    rate: Float[Array, ""]


@final
class CoarseCorrection(eqx.Module):
    """Part of a preconditioner: an inverse of the step's matrix in coarser spaces.

    - `diagonal`: at the corners, (corners,) [J/K]; `inverse`: (parts, parts) [K/J].
    - `free`: 1 at nodes whose temperature is not prescribed, 0 at the rest, (nodes,); or None.
    - `worth`: whether the step is so long that it pays.
    """

    spaces: CoarseSpaces
    diagonal: Float[Array, " corners"]
    inverse: Float[Array, "parts parts"]
    free: Float[Array, " nodes"] | None
    worth: Bool[Array, ""]

    def apply(self, heat: Float[Array, "nodes *batch"]) -> Float[Array, "nodes *batch"]:
        """Temperatures [K] that take up what is smooth of heat [J]; none where it does not pay."""
        return jax.lax.cond(self.worth, lambda h: self._found(h), jnp.zeros_like, heat)

    def _found(self, heat: Float[Array, "nodes *batch"]) -> Float[Array, "nodes *batch"]:
        spaces, wide = self.spaces, range(1, heat.ndim)
        free = None if self.free is None else jnp.expand_dims(self.free, wide)
        lacking = spaces.corners(heat if free is None else free * heat)
        level = self.inverse @ spaces.sums(lacking)
        found = level.at[spaces.part].get(mode="promise_in_bounds")
        if spaces.ends is not None:
            found = found + lacking / jnp.expand_dims(self.diagonal, wide)
        found = spaces.nodes(found)
        return found if free is None else free * found


def coarse_matrices(
    space: Discretisation,
    conductivity: Float[Array, " cells"] | Float[Array, "cells 3 3"],
    capacity: Float[Array, " cells"],
) -> CoarseMatrices | None:
    """M [J/K] and K [W/K] on linear cells and on the parts; None where the mesh has no such spaces.

    Arguments:

    - `conductivity`: (cells,), or a symmetric tensor, (cells, 3, 3) [W/m/K].
    - `capacity`: (cells,) [J/m3/K].
    """
    spaces = space.coarse
    if spaces is None:
        return None
    wide = (-1, 1, 1)
    flow = space.gradient
    if conductivity.ndim > 1:
        flow = jnp.einsum("cax,cxy->cay", flow, conductivity)
    stiffness = jnp.einsum("cax,cbx->cab", flow, space.gradient)
    if conductivity.ndim == 1:
        stiffness = conductivity.reshape(wide) * stiffness
    stored = (capacity * space.volume).reshape(wide) * jnp.asarray(reference_mass(1))

    def at_corners(matrix: Float[Array, "cells 4 4"]) -> Float[Array, " corners"]:
        each = jnp.diagonal(matrix, axis1=1, axis2=2)
        return jnp.zeros(len(spaces.part)).at[spaces.cells].add(each)

    def on_parts(matrix: Float[Array, "cells 4 4"]) -> Float[Array, "parts parts"]:
        part = jnp.asarray(spaces.part)[spaces.cells]
        none = jnp.zeros((spaces.parts, spaces.parts))
        return none.at[part[:, :, None], part[:, None, :]].add(matrix)

    both = (stored, stiffness)
    content, conducted = map(at_corners, both)
    rate = jnp.mean(conducted / content)
    return CoarseMatrices(spaces, content, conducted, *map(on_parts, both), rate=rate)


def coarse_correction(
    matrices: CoarseMatrices,
    weight: Time,
    held: Float[Array, " nodes"],
    free: Float[Array, " nodes"] | None,
) -> CoarseCorrection:
    """The correction for M + weight K and what holds the surface.

    Arguments:

    - `weight`: [s]; `free`: as in `CoarseCorrection`.
    - `held`: diagonal of what the surface adds, (nodes,) [J/K]; all entries of a matrix of faces
      add up to at most twice those on its diagonal.
    """
    spaces = matrices.spaces
    conducted = weight * matrices.stiffness
    worth = weight * matrices.rate > WORTH
    held = 2 * spaces.corners(jnp.maximum(held, 0.0))

    def invert(held: Float[Array, " corners"]) -> Float[Array, "parts parts"]:
        dense = matrices.stored_parts + weight * matrices.stiffness_parts
        root = jnp.linalg.cholesky(dense + jnp.diag(spaces.sums(held)))
        # `inv` takes up to ten times as long where LAPACK has threads that wait for each other.
        return cho_solve((root, True), jnp.eye(spaces.parts))

    nothing = jnp.zeros_like(matrices.stored_parts)
    inverse = jax.lax.cond(worth, invert, lambda _: nothing, held)
    return CoarseCorrection(spaces, matrices.stored + conducted + held, inverse, free, worth)
