"""How far a recovered field is from a known one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from jaxtyping import Float

from thermo.inverse._estimate import RecoveredField, weighted_quantile
from thermo.mesh import Mesh, face_areas


@final
@dataclass(frozen=True)
class FieldScores:
    """A recovered field against the truth, over the surface.

    - `error`: mean of |phi / truth - 1| by area [1]; `plain_error`: by count of faces.
    - `ratio`: median of phi / truth by area [1].
    - `width`: from the 5 % to the 95 % quantile of phi / truth by area [1], the paper's normalised
      width where the truth is uniform; `width_by_median`: of phi / median(phi).

    Source: paper, table 1 (checklist G1 to G3).
    """

    error: float
    plain_error: float
    ratio: float
    width: float
    width_by_median: float


def field_scores(
    mesh: Mesh, field: RecoveredField, truth: float | Float[np.ndarray, " faces"]
) -> FieldScores:
    """Scores [1] of a field against its true values on the faces, in the field's unit."""
    areas = face_areas(mesh)
    ratio = field.faces / truth

    def width(values: Float[np.ndarray, " faces"]) -> float:
        low, high = (weighted_quantile(values, areas, share) for share in (0.05, 0.95))
        return high - low

    return FieldScores(
        error=float(np.average(np.abs(ratio - 1), weights=areas)),
        plain_error=float(np.mean(np.abs(ratio - 1))),
        ratio=weighted_quantile(ratio, areas, 0.5),
        width=width(ratio),
        width_by_median=width(field.faces) / weighted_quantile(field.faces, areas, 0.5),
    )
