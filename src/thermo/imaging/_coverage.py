"""How much of a surface cameras read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import trimesh

from thermo.mesh import Surface

from ._camera import Camera
from ._surface_samples import samples_at

_TRIED: Final = 4000
"""Points drawn on the surface [1]: the share is known to 0.8 % (one standard deviation)."""


def coverage(
    surface: Surface,
    cameras: Sequence[Camera],
    *,
    grazing: float | int = 70.0,
    margin: int = 2,
    seed: int = 0,
) -> float:
    """The share of a surface's area that at least one camera reads [1].

    Points are drawn evenly over the area with `seed`; a point counts where `samples_at` reads it,
    with the same `grazing` [deg] and `margin` [px]. What no camera reads tells a fit nothing by
    itself, however many samples there are elsewhere.
    """
    body = trimesh.Trimesh(surface.vertices, surface.triangles, process=False)
    random = np.random.default_rng(seed)
    points = np.asarray(trimesh.sample.sample_surface(body, _TRIED, seed=random)[0], float)
    found = samples_at(surface, cameras, points, grazing=grazing, margin=margin)
    return float(found.seen.any(axis=0).mean())
