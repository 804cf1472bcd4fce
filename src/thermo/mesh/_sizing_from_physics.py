"""Cell sizes chosen from physics."""

from __future__ import annotations

from typing import Final

import numpy as np

from thermo.errors import InputError

from ._node_count import nodes_for, shape_of
from ._sizing import TOLERANCE, Sizing, heat_depth
from ._surface import Surface

CELLS_ACROSS: Final = 12.0
"""Cells along the box diagonal that suffice where the temperature varies over the whole body."""

CELLS_THROUGH: Final = 2.0
"""Cells through the thin parts of the body."""

STEEPEST: Final = 0.8
"""Largest growth of the edge length with the distance from the surface."""

LOOSE: Final = 7e-4
"""Largest tolerance of the surface that is traded for nodes, over the box diagonal."""

TOO_MANY: Final = 2.5
"""Nodes over those asked for from which a finely curved surface is loosened further: its area then
comes out less exactly."""

LOOSEST: Final = 2e-3
"""Largest tolerance there, over the box diagonal."""

LOOSEST_THIN: Final = 0.1
"""The same over the thickness of the thin parts, if that is less."""

LEAST_GAIN: Final = 0.005
"""Smallest share of the nodes that making the skin 3 % coarser must save to be worth it."""


def sizing_from_physics(
    surface: Surface,
    *,
    diffusivity: float | int,
    duration: float | int,
    cells_per_depth: float | int = 1.0,
    max_nodes: int = 30000,
) -> Sizing:
    """Edge lengths for heat that has travelled sqrt(diffusivity duration) deep.

    The skin gets `cells_per_depth` edges per depth and two through the thin parts, the inside a
    twelfth of the box diagonal. Where the TET10 mesh is expected to pass `max_nodes`, the skin is
    made coarser and the tolerance looser step by step; `resolution` then says how well the layer
    is resolved. The count is an estimate, and a finely curved surface sets a lower limit to it: up
    to 2.5 times as many nodes are taken before its tolerance is loosened further.

    Arguments:

    - `surface`: closed and turned outward [m].
    - `diffusivity`: the smallest expected [m2/s].
    - `duration`: time over which the body is watched [s].
    - `cells_per_depth`: wanted quadratic cells within the depth [1].
    - `max_nodes`: largest number of TET10 nodes [1].

    Raises `InputError` for numbers that are not positive.
    """
    depth = heat_depth(diffusivity, duration)
    limits = (("cells_per_depth", cells_per_depth, 0.1), ("max_nodes", max_nodes, 200))
    for name, value, least in limits:
        if not (np.isfinite(value) and value >= least):
            raise InputError(
                f"{name} is too small",
                where=name,
                value=value,
                limit=f"{least:g} or more",
                remedy=f"leave {name} at its default",
            )
    shape = shape_of(surface)
    thin = float(np.quantile(shape.through, 0.05))
    coarsest = shape.diagonal / CELLS_ACROSS
    skin = min(depth / cells_per_depth, coarsest, max(thin / CELLS_THROUGH, coarsest / 3.0))
    most = max(LOOSE, min(LOOSEST, LOOSEST_THIN * thin / shape.diagonal))
    tolerance, loosest, enough = TOLERANCE, LOOSE, float(max_nodes)
    before = np.inf
    while True:
        core = max(coarsest, skin)
        ramp = max(depth, (core - skin) / STEEPEST)
        sizing = Sizing(skin, core, ramp, tolerance * shape.diagonal)
        nodes = nodes_for(shape, sizing, tolerance * shape.diagonal)
        # Once the curved sides alone set the count, a coarser skin only loses accuracy.
        if nodes > (1.0 - LEAST_GAIN) * before:
            loosest, enough = most, TOO_MANY * max_nodes
        if nodes <= enough or (tolerance >= most and enough > max_nodes):
            return sizing
        before = nodes
        skin, tolerance = 1.03 * skin, min(1.1 * tolerance, loosest)
