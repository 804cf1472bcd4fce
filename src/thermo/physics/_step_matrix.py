"""The matrix of an implicit step."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from thermo.physics._coarse_correction import CoarseCorrection
from thermo.physics._pattern import Pattern, Rows, row_product


@final
class StepMatrix(eqx.Module):
    """Symmetric positive definite matrix [J/K] on the edges of a mesh.

    - `diagonal`: (nodes,); `rows`: the rest, padded row by row.
    - `coarse`: an inverse in coarser spaces, or None.

    No derivative flows through it: that of a step is taken from the balance of heat that the step
    meets, which needs no matrix.
    """

    pattern: Pattern
    diagonal: Float[Array, " nodes"]
    rows: Rows
    coarse: CoarseCorrection | None = None

    def mv(self, vector: Float[Array, "nodes *batch"]) -> Float[Array, "nodes *batch"]:
        """Matrix [J/K] times one vector [K] or several."""
        return row_product(self.pattern, self.diagonal, self.rows, vector)

    def as_matrix(self) -> Float[Array, "nodes nodes"]:
        """Dense form [J/K], for small meshes."""
        dense = jnp.diag(self.diagonal)
        pattern = self.pattern
        for values, place, (low, high, _) in zip(
            self.rows, pattern.columns, pattern.bounds, strict=True
        ):
            row = jnp.broadcast_to(jnp.arange(low, high), place.shape)
            dense = dense.at[row, place].add(values)
        return dense
