"""What is left of residuals and signatures when all that is free anyway has taken its part."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Float
from scipy.linalg import cho_factor, cho_solve


@final
class Projection(eqx.Module):
    """P = I - A (A' A)^-1 A', of the slopes A by all that is free.

    - `columns`: A, (values, free) [1]; `factor`: of A' A, its Cholesky factor [1].

    Source: Rao, Proc. Camb. Phil. Soc. 44 (1948) 50, scores beside what is estimated.
    """

    columns: Float[np.ndarray, "values free"]
    factor: tuple[np.ndarray, bool]

    def part(self, of: Float[np.ndarray, "values *any"]) -> Float[np.ndarray, "free *any"]:
        """(A' A)^-1 A' times values [1]: what the free entries take of each."""
        return cho_solve(self.factor, self.columns.T @ of)

    def left(self, of: Float[np.ndarray, "values *any"]) -> Float[np.ndarray, "values *any"]:
        """P times values [1]."""
        return of - self.columns @ self.part(of)


def projection(free: Float[np.ndarray, "values free"]) -> Projection:
    """What the free entries leave.

    Columns of no size are left out; a rounding of the largest keeps the rest apart.
    """
    size = np.sqrt((free**2).sum(0))
    columns = free[:, size > 0]
    normal = columns.T @ columns + 1e-12 * np.diag(size[size > 0] ** 2)
    return Projection(columns, cho_factor(normal))
