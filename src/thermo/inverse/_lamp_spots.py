"""Cells under lamps whose spots are narrower than cells would be."""

from __future__ import annotations

from typing import Final

from thermo.mesh import Fine, Sizing, Surface, in_beam
from thermo.observe import Heater, Scene

# Edges over the spot's standard deviation [1]: those up to which a spot is met well enough, and
# those asked for where it is not, as the mesher's come out longer.
_ENOUGH: Final = 1.0
_EDGE: Final = 0.5
# How far from the axis, in the same: beyond it is a seventh of the light.
_REACH: Final = 2.0
# Quadratic nodes that one such spot takes on a body of much longer cells, counted [1].
_NODES: Final = 2000
# What all spots may take of the nodes of a mesh [1].
_SHARE: Final = 0.5


def lamp_spots(scene: Scene, surface: Surface, sizing: Sizing, max_nodes: int) -> tuple[Fine, ...]:
    """Where lamps of a scene need shorter edges than `sizing` has at the surface [m].

    Where a spot's standard deviation is shorter than an edge, edges of half of it are asked for,
    and longer ones where many spots would take more than half of `max_nodes` [1].
    """
    lamps = [run.heater for run in scene.runs.values() if run.heater is not None]
    narrow = {_axis(one): one for one in lamps if _ENOUGH * one.radius < sizing.skin}
    longer = max(1.0, (_NODES * len(narrow) / (_SHARE * max_nodes)) ** (1 / 3))
    found = []
    for lamp in narrow.values():
        edge = _EDGE * longer * lamp.radius
        lit = in_beam(surface, lamp.centre, lamp.direction, _REACH * lamp.radius)
        if edge < sizing.skin and len(lit):
            found.append(Fine(lit, edge))
    return tuple(found)


def _axis(lamp: Heater) -> tuple[float, ...]:
    return (*lamp.centre, *lamp.direction, lamp.radius)
