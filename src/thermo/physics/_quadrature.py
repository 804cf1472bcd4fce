"""Gauss rules on the reference triangle and tetrahedron, in barycentric coordinates."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

_PAIRS = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))


def triangle_rule(
    order: int,
) -> tuple[Float[np.ndarray, "points 3"], Float[np.ndarray, " points"]]:
    """Points and weights [1] on a triangle; the weights sum to one (multiply by the area).

    Arguments:

    - `order`: 1 gives the 3-point rule (exact to degree 2, the mass of linear faces), 2 the
      6-point rule (exact to degree 4, the mass of quadratic faces).

    Source: Strang and Fix, An Analysis of the Finite Element Method, table 4.1.
    """
    if order == 1:
        return np.full((3, 3), 1 / 6) + np.eye(3) / 2, np.full(3, 1 / 3)
    # Exact values: w = (620 +- sqrt(213125 - 53320 sqrt(10))) / 3720, and the matching points.
    root = np.sqrt(10.0)
    corner = np.sqrt(38 - 44 * np.sqrt(2 / 5))
    first, second = (8 - root + corner) / 18, (8 - root - corner) / 18
    split = np.sqrt(213125 - 53320 * root)
    weights = ((620 + split) / 3720, (620 - split) / 3720)
    points = [np.roll([1 - 2 * a, a, a], shift) for a in (first, second) for shift in range(3)]
    return np.array(points), np.repeat(weights, 3)


def tetrahedron_rule(
    degree: int,
) -> tuple[Float[np.ndarray, "points 4"], Float[np.ndarray, " points"]]:
    """Points and weights [1] on a tetrahedron, exact to `degree`; the weights sum to one.

    Symmetric rules of 4 and 14 points for degrees 2 and 5, else a conical product of Gauss-Jacobi
    rules: positive weights for any degree.

    Source: Hammer and Stroud, MTAC 10 (1956) 137; Walkington, Quadrature on simplices of arbitrary
    dimension (2000); Stroud, Approximate Calculation of Multiple Integrals, section 2.3.
    """
    from scipy.special import roots_jacobi

    if degree == 2:
        return _about_corners((5 - np.sqrt(5.0)) / 20), np.full(4, 0.25)
    if degree == 5:
        near, far = 0.31088591926330060980, 0.092735250310891226402
        edge, rest = 0.045503704125649649492, 0.5 - 0.045503704125649649492
        middle = [[rest if corner in pair else edge for corner in range(4)] for pair in _PAIRS]
        weights = (0.11268792571801585080, 0.073493043116361949544, 0.042546020777081466438)
        points = np.concatenate([_about_corners(near), _about_corners(far), np.array(middle)])
        return points, np.repeat(weights, (4, 4, 6))

    count = degree // 2 + 1
    axes = [roots_jacobi(count, float(power), 0.0) for power in (2, 1, 0)]
    nodes = [(x + 1) / 2 for x, _ in axes]
    weights = [w / w.sum() for _, w in axes]
    u, v, w = np.meshgrid(*nodes, indexing="ij")
    first = u
    second = v * (1 - u)
    third = w * (1 - u) * (1 - v)
    points = np.stack([1 - first - second - third, first, second, third], -1).reshape(-1, 4)
    return points, np.einsum("i,j,k->ijk", *weights).ravel()


def _about_corners(away: float) -> Float[np.ndarray, "4 4"]:
    """Points each nearest to one corner, or farthest from it, by the share of the others [1]."""
    return np.full((4, 4), away) + (1 - 4 * away) * np.eye(4)
