"""How well a mesh resolves the layer that heat reaches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from ._geometry import squared_edges
from ._mesh import Mesh
from ._sizing import heat_depth

FINE: Final = 1.5
"""Quadratic cells within the depth from which the layer counts as well resolved."""

FAIR: Final = 0.6
"""Quadratic cells within the depth below which the layer counts as too coarse."""


@final
@dataclass(frozen=True)
class Resolution:
    """The depth that heat reaches and the cells that resolve it.

    Arguments:
    - `depth`: sqrt(diffusivity duration) [m].
    - `skin_edge`: mean edge length of the cells behind the boundary faces [m].
    - `cells_per_depth`: depth over skin_edge.
    """

    depth: float
    skin_edge: float
    cells_per_depth: float

    def describe(self) -> str:
        """One sentence for people."""
        if self.cells_per_depth >= FINE:
            verdict = "well resolved"
        elif self.cells_per_depth >= FAIR:
            verdict = "enough for quadratic cells, coarse for linear ones"
        else:
            verdict = "too coarse: make the skin finer or the record longer"
        return (
            f"Heat goes {1e3 * self.depth:.1f} mm deep and surface cells are "
            f"{1e3 * self.skin_edge:.1f} mm long, {self.cells_per_depth:.1f} cells within the "
            f"depth: {verdict}."
        )


def resolution(mesh: Mesh, *, diffusivity: float | int, duration: float | int) -> Resolution:
    """Compare the surface cells with the depth sqrt(diffusivity duration).

    Arguments:
    - `diffusivity`: conductivity / (density heat capacity) [m2/s].
    - `duration`: time over which the body is watched [s].

    Raises `InputError` unless both are positive.
    """
    depth = heat_depth(diffusivity, duration)
    skin = np.unique(mesh.owners)
    edge = float(np.sqrt(squared_edges(mesh.nodes, mesh.cells[skin])).mean())
    return Resolution(depth, edge, depth / edge)
