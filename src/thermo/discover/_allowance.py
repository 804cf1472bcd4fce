"""What a residual is measured in: noise, and what the stated model may be wrong by."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from jaxtyping import Float

from thermo.discover._softening import Block, softened


@final
@dataclass(frozen=True)
class Allowance:
    """S^-1/2 of S = I + W t^2 W' + E E': noise, smooth shapes W, and columns E of known shape.

    - `runs`: their smooth shapes, and how far each is softened.
    - `lost` (values, errors): orthonormal directions of the softened columns [1]; `share`: of each
      that is taken off [1].

    Fits, scores and comparisons of rivals all use it, so that none gains by what is allowed for.

    Source: Kennedy and O'Hagan, J. R. Statist. Soc. B 63 (2001) 425, a discrepancy of the model.
    """

    runs: list[Block]
    lost: Float[np.ndarray, "values errors"]
    share: Float[np.ndarray, " errors"]

    def whiten(
        self, values: Float[np.ndarray, "values columns"]
    ) -> Float[np.ndarray, "values columns"]:
        """Columns [1], all that is allowed for scaled to variance one."""
        made = softened(self.runs, values)
        if self.share.size:
            made -= self.lost @ (self.share[:, None] * (self.lost.T @ made))
        return made


def allowance(runs: list[Block], errors: Float[np.ndarray, "values errors"]) -> Allowance:
    """Of the runs' smooth shapes and columns of errors whose amplitude is about one [1]."""
    return beside(Allowance(runs, np.zeros((len(errors), 0)), np.zeros(0)), errors)


def beside(allowed: Allowance, errors: Float[np.ndarray, "values errors"]) -> Allowance:
    """With more columns of errors [1] beside those that are allowed for."""
    size = np.sqrt(1 / (1 - allowed.share) ** 2 - 1)
    every = np.concatenate([allowed.lost * size, softened(allowed.runs, errors)], 1)
    turned, size, _ = np.linalg.svd(every, full_matrices=False)
    return Allowance(allowed.runs, turned, 1 - 1 / np.sqrt(1 + size**2))


NOTHING_ALLOWED = Allowance([], np.zeros((0, 0)), np.zeros(0))
"""Noise alone."""
