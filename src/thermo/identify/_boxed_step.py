"""Least squares along slopes, no unknown moved further than its box lets it."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Float
from scipy.optimize import lsq_linear

# Singular values of unit columns below this share of the largest are of directions that slopes
# of a usual accuracy do not show [1].
_UNSEEN: Final = 1e-6


def boxed_step(
    residual: Float[np.ndarray, " values"],
    jacobian: Float[np.ndarray, "values unknowns"],
    box: Float[np.ndarray, "unknowns 2"],
) -> tuple[Float[np.ndarray, " unknowns"], float]:
    """The step that leaves the least |residual + jacobian step|^2 within a box around nothing.

    Directions that the slopes do not show are left alone. An unknown whose box is empty stays.

    Arguments:

    - `residual`: whitened residual [1]; `jacobian`: its slopes [1].
    - `box`: least and largest step of each unknown [1], zero within or at an end.

    Returns the step [1], and what it takes off the sum of squares if the slopes are right [1].

    Only squares count, so that `reduced` parts, as few as there are unknowns, give the same.

    Source: the bounded-variable algorithm of Stark and Parker (1995), as SciPy has it.
    """
    free = box[:, 0] < box[:, 1]
    step = np.zeros(len(box))
    if not free.any():
        return step, 0.0
    # Columns of length one: what is seen of a direction must not hang on the unknowns' scales.
    length = np.linalg.norm(jacobian[:, free], axis=0)
    length = np.where(length > 0, length, 1.0)
    unit = jacobian[:, free] / length
    matrix = np.concatenate([unit, _UNSEEN * np.eye(len(length))])
    right = np.concatenate([-residual, np.zeros(len(length))])
    found = lsq_linear(matrix, right, tuple((box[free] * length[:, None]).T), method="bvls")
    # Rounding must not carry a step out of its box.
    step[free] = np.clip(found.x / length, *box[free].T)
    left = residual + unit @ found.x
    return step, max(float(residual @ residual - left @ left), 0.0)


def reduced(
    residual: Float[np.ndarray, " values"], jacobian: Float[np.ndarray, "values unknowns"]
) -> tuple[Float[np.ndarray, " few"], Float[np.ndarray, "few unknowns"]]:
    """The part of a residual [1] that its slopes [1] can change, and they, turned to few rows."""
    turned, triangle = np.linalg.qr(jacobian)
    return turned.T @ residual, triangle
