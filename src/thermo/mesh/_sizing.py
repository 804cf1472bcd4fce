"""Cell sizes chosen from physics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from thermo.errors import InputError

from ._surface import Surface
from ._thickness import thicknesses

CELLS_ACROSS: Final = 12.0
"""Cells along the box diagonal that suffice where the temperature varies over the whole body."""

CELLS_THROUGH: Final = 2.0
"""Cells through the thin parts of the body."""

STEEPEST: Final = 0.8
"""Largest growth of the edge length with the distance from the surface."""

NODES_PER_EDGE_CUBED: Final = 12.0
"""TET10 nodes in a volume of one edge length cubed, counted on meshes made by pytetwild."""


@final
@dataclass(frozen=True)
class Sizing:
    """Wanted edge lengths of a graded mesh.

    Arguments:

    - `skin`: edge length at the surface [m].
    - `core`: edge length deep inside [m], not below `skin`.
    - `depth`: thickness of the layer over which the length grows from skin to core [m].
    """

    skin: float | int
    core: float | int
    depth: float | int

    def __post_init__(self) -> None:
        """Refuse lengths that are not positive or a core finer than the skin."""
        for name, value in (("skin", self.skin), ("core", self.core), ("depth", self.depth)):
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(
                    "a length is not positive", where=f"sizing.{name}", value=value,
                    limit="a finite length above 0 m", remedy="state the length in metres",
                )
        if self.core < self.skin:
            raise InputError(
                "the inside is finer than the skin", where="sizing.core", value=f"{self.core:g} m",
                limit=f"skin = {self.skin:g} m or more", remedy="make core at least as long as skin",
            )


def heat_depth(diffusivity: float | int, duration: float | int) -> float:
    """Depth sqrt(diffusivity duration) [m] that heat reaches in `duration` [s].

    Arguments: `diffusivity` [m2/s], `duration` [s]. Raises `InputError` unless both are positive.
    """
    for name, value, unit in (("diffusivity", diffusivity, "m2/s"), ("duration", duration, "s")):
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(
                f"the {name} is not positive", where=name, value=value,
                limit=f"a finite number above 0 {unit}", remedy=f"state the {name} in {unit}",
            )
    return float(np.sqrt(diffusivity * duration))


def expected_nodes(surface: Surface, sizing: Sizing) -> float:
    """Estimate of the TET10 nodes of the mesh: the integral of 12 / edge^3 over the body.

    The skin layer is taken as area times depth, at most the whole volume; the edge length grows
    linearly through it.
    """
    volume = abs(surface.volume())
    layer = min(surface.area() * sizing.depth, volume)
    skin, core = sizing.skin, sizing.core
    # Mean of h^-3 while h runs linearly from skin to core is (skin + core) / (2 skin^2 core^2).
    dense = (skin + core) / (2.0 * skin**2 * core**2)
    return NODES_PER_EDGE_CUBED * (layer * dense + (volume - layer) / core**3)


def sizing_from_physics(
    surface: Surface,
    *,
    diffusivity: float | int,
    duration: float | int,
    cells_per_depth: float | int = 1.0,
    max_nodes: int = 30000,
) -> Sizing:
    """Edge lengths for heat that has travelled sqrt(diffusivity duration) deep.

    The skin gets `cells_per_depth` edges per depth, the inside at most a twelfth of the box
    diagonal and half the thin parts' thickness. Where the TET10 mesh would pass `max_nodes`, both
    are made longer together; `resolution` then says how well the layer is resolved.

    Arguments:

    - `diffusivity`: the smallest expected [m2/s].
    - `duration`: time over which the body is watched [s].
    - `cells_per_depth`: wanted quadratic cells within the depth.
    - `max_nodes`: largest number of TET10 nodes.

    Raises `InputError` for numbers that are not positive.
    """
    depth = heat_depth(diffusivity, duration)
    for name, value, least in (("cells_per_depth", cells_per_depth, 0.1), ("max_nodes", max_nodes, 200)):
        if not (np.isfinite(value) and value >= least):
            raise InputError(
                f"{name} is too small", where=name, value=value, limit=f"{least:g} or more",
                remedy=f"leave {name} at its default",
            )
    through = thicknesses(surface)
    thin = float(np.quantile(through, 0.05)) if through.size else surface.diagonal()
    coarsest = surface.diagonal() / CELLS_ACROSS
    core = coarsest
    skin = min(depth / cells_per_depth, core, max(thin / CELLS_THROUGH, core / 4.0))
    sizing = Sizing(skin, core, max(depth, (core - skin) / STEEPEST))
    for _ in range(60):
        nodes = expected_nodes(surface, sizing)
        if nodes <= max_nodes:
            break
        grow = max(1.01, (nodes / max_nodes) ** (1.0 / 4.0))
        skin = skin * grow
        core = max(core, skin)
        sizing = Sizing(skin, core, max(depth, (core - skin) / STEEPEST))
    return sizing
