"""Surfaces whose triangles are small enough to carry a picture."""

from __future__ import annotations

from typing import Final

import numpy as np
import trimesh

from thermo.mesh import Surface
from thermo.observe import check_number

_ROUNDS: Final = 20
"""Times that an edge may be halved [1]: a million parts."""


def refined(surface: Surface, longest: float | int) -> Surface:
    """The same surface in triangles none of whose edges is longer than `longest` [m].

    Triangles that are longer are cut in four at the middles of their edges, again and again.
    Temperatures are carried by vertices: a flat face of two triangles could show no spot in its
    middle. Where a small triangle lies beside a large one, a vertex lies on the other's edge.

    Raises `InputError` for a length that is not above 0.
    """
    most = check_number(longest, where="longest", quantity="length of an edge [m]", above=0.0)
    vertices, triangles = trimesh.remesh.subdivide_to_size(
        surface.vertices, surface.triangles, most, max_iter=_ROUNDS
    )[:2]
    return Surface(np.asarray(vertices, float), np.asarray(triangles, np.int64))
