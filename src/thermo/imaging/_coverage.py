"""How much of a surface cameras read."""

from __future__ import annotations

from typing import Final

import numpy as np
import trimesh

from thermo.mesh import triangle_normals

from ._looks import Looks
from ._surface_samples import read_at

_TRIED: Final = 4000
"""Points drawn on the surface [1]: the share is known to 0.8 % (one standard deviation)."""


def coverage(looks: Looks, *, seed: int = 0) -> float:
    """The share of a surface's area that at least one camera reads [1].

    Points are drawn evenly over the area with `seed`; a point counts where `samples_at` reads it.
    What no camera reads tells a fit nothing by itself, however many samples there are elsewhere.

    Arguments: `looks`, made by `looks_of`.
    """
    surface = looks.surface
    body = trimesh.Trimesh(surface.vertices, surface.triangles, process=False)
    random = np.random.default_rng(seed)
    drawn, face = trimesh.sample.sample_surface(body, _TRIED, seed=random)[:2]
    points = np.asarray(drawn, float)
    normals, _ = triangle_normals(surface.vertices, surface.triangles)
    found = read_at(looks, points, points, normals[face])
    return float(found.seen.any(axis=0).mean())
