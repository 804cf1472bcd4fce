"""Which share of a tetrahedron or a triangle lies where a linear function is above zero."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Float

# Heights nearer to each other than this, over the largest, are moved apart by it [1].
_APART: Final = 1e-5


def share_above(heights: Float[np.ndarray, "parts corners"]) -> Float[np.ndarray, " parts"]:
    """Share of each simplex [1] in which a function linear between its corners is above zero.

    Arguments:

    - `heights`: the function at the corners, three of a triangle or four of a tetrahedron, in any
      unit.

    With n + 1 corners, sum over those below zero of (-h_i)^n / prod_{j != i} (h_j - h_i) lies below
    it: a truncated power's divided difference. It is taken on the side of fewer corners, where
    fewer terms cancel; equal heights are moved apart by a hundred-thousandth.

    Source: Curry and Schoenberg, J. Analyse Math. 17 (1966) 71, B-splines as sections of simplices.
    """
    corners = heights.shape[1]
    turned = (heights < 0).sum(1) > corners // 2
    mine = np.sort(np.where(turned[:, None], -heights, heights), axis=1)
    largest = np.abs(mine).max(1, keepdims=True)
    mine = mine / np.where(largest > 0, largest, 1.0) + _APART * np.arange(corners)
    below = np.zeros(len(mine))
    for one in range(corners):
        others = np.delete(mine, one, axis=1) - mine[:, [one]]
        part = np.maximum(-mine[:, one], 0.0) ** (corners - 1) / np.prod(others, axis=1)
        below += part
    below = np.clip(below, 0.0, 1.0)
    return np.where(turned, below, 1.0 - below)
