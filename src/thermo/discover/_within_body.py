"""Where in a body an effect is whose shape may have its middle beside it."""

from __future__ import annotations

from typing import Final

import numpy as np
from jaxtyping import Float

from thermo.mesh import Mesh, nearest_triangle

# What lies on a cell's side counts as within it despite rounding, over the cell's own size [1].
_SLACK: Final = 1e-9


def within_body(point: Float[np.ndarray, "3"], mesh: Mesh) -> Float[np.ndarray, "3"]:
    """A point [m] where a cell holds it, else the nearest one of the surface.

    A bell beside the body warms or cools its rim, and its middle is no place in the body.
    """
    corners = mesh.nodes[mesh.cells[:, :4]]
    edges = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
    shares = np.linalg.solve(edges, (point - corners[:, 0])[..., None])[..., 0]
    if np.any((shares.min(1) >= -_SLACK) & (shares.sum(1) <= 1 + _SLACK)):
        return point
    faces = mesh.nodes[mesh.faces[:, :3]]
    nearest, weights, _ = nearest_triangle(faces, point[None])
    return weights[0] @ faces[nearest[0]]
