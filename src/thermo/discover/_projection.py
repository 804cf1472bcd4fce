"""What is left of residuals and signatures when all that is free anyway has taken its part."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Float
from scipy.linalg import cho_factor, cho_solve


@final
class Projection(eqx.Module):
    """S^-1 = I - A (A' A + Q)^-1 A', of whitened nuisances A with prior precisions Q.

    - `columns`: A, (values, nuisances) [1]; `factor`: of A' A + Q, its Cholesky factor [1].

    Source: the Woodbury identity; section 6 of the design, S.
    """

    columns: Float[np.ndarray, "values nuisances"]
    factor: tuple[np.ndarray, bool]

    def part(self, of: Float[np.ndarray, "values *any"]) -> Float[np.ndarray, "nuisances *any"]:
        """(A' A + Q)^-1 A' times whitened values [1]: what the nuisances take of each."""
        return cho_solve(self.factor, self.columns.T @ of)

    def left(self, of: Float[np.ndarray, "values *any"]) -> Float[np.ndarray, "values *any"]:
        """S^-1 times whitened values [1]."""
        return of - self.columns @ self.part(of)


def projection(
    free: Float[np.ndarray, "values free"], believed: Float[np.ndarray, "values believed"]
) -> Projection:
    """Of nuisances that nothing is known of, and others whose amplitude is about one [1].

    Columns of no size are left out; a rounding of the largest keeps the rest apart.
    """
    columns = np.concatenate([free, believed], 1)
    precision = np.r_[np.zeros(free.shape[1]), np.ones(believed.shape[1])]
    size = np.sqrt((columns**2).sum(0))
    kept = size > 0
    columns, precision, size = columns[:, kept], precision[kept], size[kept]
    normal = columns.T @ columns + np.diag(precision)
    normal += 1e-12 * np.diag(size**2)
    return Projection(columns, cho_factor(normal))
