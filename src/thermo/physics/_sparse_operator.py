"""The matrix of an implicit step as a lineax operator."""

from __future__ import annotations

from typing import Any, final

import jax
import jax.numpy as jnp
import lineax as lx
from jaxtyping import Array, Float

from thermo.physics._edge_product import edge_product
from thermo.physics._pattern import Pattern


@final
class SparseOperator(lx.AbstractLinearOperator):
    """Symmetric positive definite matrix [J/K] on the edges of a mesh.

    - `diagonal` (nodes,), `edges` (edges,): the values; derivatives flow through these.
    - `rows` (entries,): the same values padded row by row, for the solver; never differentiated.
    """

    pattern: Pattern
    diagonal: Float[Array, " nodes"]
    edges: Float[Array, " edges"]
    rows: Float[Array, " entries"]

    def mv(self, vector: Float[Array, " nodes"]) -> Float[Array, " nodes"]:
        """Matrix [J/K] times vector [K]."""
        return edge_product(self.pattern, self.diagonal, self.edges, vector)

    def as_matrix(self) -> Float[Array, "nodes nodes"]:
        """Dense form [J/K], for small meshes."""
        first, second = self.pattern.first, self.pattern.second
        dense = jnp.diag(self.diagonal).at[first, second].set(self.edges)
        return dense.at[second, first].set(self.edges)

    def transpose(self) -> SparseOperator:
        """Itself, being symmetric."""
        return self

    def in_structure(self) -> jax.ShapeDtypeStruct:
        """Shape of the vectors that it takes."""
        return jax.eval_shape(lambda: self.diagonal)

    def out_structure(self) -> jax.ShapeDtypeStruct:
        """Shape of the vectors that it gives."""
        return jax.eval_shape(lambda: self.diagonal)


def _itself(operator: SparseOperator) -> SparseOperator:
    return operator


def _yes(operator: SparseOperator) -> bool:
    del operator
    return True


def _no(operator: SparseOperator) -> bool:
    del operator
    return False


for query in (lx.materialise, lx.linearise, lx.conj):
    query.register(SparseOperator)(_itself)
for query in (lx.is_symmetric, lx.is_positive_semidefinite):
    query.register(SparseOperator)(_yes)
for query in (
    lx.is_diagonal,
    lx.has_unit_diagonal,
    lx.is_lower_triangular,
    lx.is_upper_triangular,
    lx.is_negative_semidefinite,
    lx.is_tridiagonal,
):
    query.register(SparseOperator)(_no)


@lx.diagonal.register(SparseOperator)
def _diagonal(operator: SparseOperator) -> Any:
    return operator.diagonal


@lx.tridiagonal.register(SparseOperator)
def _tridiagonal(operator: SparseOperator) -> Any:
    raise NotImplementedError("a mesh operator is not tridiagonal")


def frozen(values: Float[Array, "*any"]) -> Float[Array, "*any"]:
    """Padded rows without their derivative: `edges` and `diagonal` carry it."""
    return jax.lax.stop_gradient(values)
