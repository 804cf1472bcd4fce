"""Meshes with shorter edges where a surface turns inward."""

from __future__ import annotations

from typing import Final

import numpy as np

from thermo.inverse._body import Meshing, make_mesh, sizing_of
from thermo.mesh import Fine, Mesh, Sizing, Surface, expected_nodes, inner_edges
from thermo.observe import Scene

# Other edges of a mesh over those at inner edges of the surface where it is as fine as a fit's,
# quadratic nodes that a point there takes, counted on a cup, and the most that all may add to a
# mesh that has as many as it may [1].
_SHORTER: Final = 2.0**1.5
_NODES_EACH: Final = 110
_MORE: Final = 0.5


def mesh_to_measure(
    scene: Scene,
    surface: Surface,
    diffusivity: float,
    meshing: Meshing,
    *,
    finer: float,
    fine: tuple[Fine, ...] = (),
) -> Mesh:
    """As `make_mesh`, with shorter edges [m] where the surface turns inward as well.

    For a mesh whose readings stand for themselves, or that others are measured against.
    """
    sizing = sizing_of(scene, surface, diffusivity, meshing).divided(finer)
    fine = (*fine, *at_inner_edges(surface, sizing, finer, meshing.max_nodes))
    return make_mesh(scene, surface, diffusivity, meshing, finer=finer, fine=fine)


def at_inner_edges(
    surface: Surface, sizing: Sizing, finer: float, max_nodes: int
) -> tuple[Fine, ...]:
    """Shorter edges [m] where a surface turns inward, as short as nodes allow.

    What cells make wrong there falls as h^(4/3) at a right angle, and as h^2 elsewhere: lengths h
    that fall there as `finer`^(3/2) let all of it fall alike, as is assumed of what meshes leave.

    Arguments: `sizing`: of the mesh [m]; `finer`: a fit's edges over its [1]; `max_nodes`: up to
    which there may be more of them, in any case by half [1].

    Source: Strang and Fix, An Analysis of the Finite Element Method (1973), chapter 8.
    """
    expected = expected_nodes(surface, sizing)
    more = max(_MORE * expected, max_nodes - expected)
    for shorter in (_SHORTER, _SHORTER / 2):
        edge = sizing.skin / (shorter * np.sqrt(finer))
        points = inner_edges(surface, edge)
        if not len(points):
            break
        if _NODES_EACH * len(points) <= more:
            return (Fine(points, edge),)
    return ()
