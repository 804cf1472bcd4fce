"""What a mesh made from a surface must fulfil."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from jaxtyping import Float

from thermo.errors import InputError

from ._build import mesh_from_cells
from ._geometry import cell_quality, triangle_normals
from ._mesh import Mesh
from ._nearest_triangle import nearest_triangle
from ._surface import Surface

LEAST_QUALITY: Final = 0.03
"""Smallest mean ratio of a cell; below it the stiffness of the cell dominates the system."""

VOLUME_TOLERANCE: Final = 0.005
"""Largest relative difference between the volumes of the mesh and the surface."""

TILT: Final = 0.1
"""Angle to the surface below it within which a face is taken for parallel to that [1]."""


def gated_mesh(nodes: np.ndarray, cells: np.ndarray, surface: Surface, *, where: str) -> Mesh:
    """A mesh of nodes [m] and cells, refused where it is not good enough.

    Raises `InputError` as `sound_mesh` does, and where the mesh's volume differs by more than half
    a percent from the surface's.
    """
    mesh = sound_mesh(nodes, cells, where=where)
    wanted, got = surface.volume(), mesh.volume()
    if not abs(got - wanted) <= VOLUME_TOLERANCE * abs(wanted):
        raise InputError(
            "the mesh does not fill the surface",
            where=where,
            value=f"volume {got:.6g} m3, surface {wanted:.6g} m3",
            limit=f"{VOLUME_TOLERANCE:.1%} difference",
            remedy="make the sizing finer, or check the surface for thin and open parts",
        )
    return replace(mesh, normals=_surface_normals(mesh, surface))


def _surface_normals(mesh: Mesh, surface: Surface) -> Float[np.ndarray, "faces 3"]:
    """Outward normals [1] of the surface below faces that are as good as parallel to it.

    Those of other faces are their own.

    Nodes lie off the surface a little, so that faces of a flat wall tilt to either side. Light
    along the wall would fall on those that tilt towards it, and none of that is made up for by the
    others: 0.4 % of a lamp's power on the walls of a cup whose floor it lights.
    """
    corners = surface.vertices[surface.triangles]
    middles = mesh.nodes[mesh.faces].mean(axis=1)
    below, _, _ = nearest_triangle(corners, middles)
    normals, _ = triangle_normals(surface.vertices, surface.triangles[below])
    parallel = np.einsum("fi,fi->f", normals, mesh.normals) >= np.cos(TILT)
    return np.where(parallel[:, None], normals, mesh.normals)


def sound_mesh(nodes: np.ndarray, cells: np.ndarray, *, where: str) -> Mesh:
    """A mesh of nodes [m] and cells, whatever it fills.

    Raises `InputError` where the mesh is empty or a cell is flat.
    """
    if len(cells) == 0:
        raise InputError(
            "the mesher found no inside",
            where=where,
            value="0 cells",
            limit="1 cell or more",
            remedy="check that the surface is closed and turned outward",
        )
    mesh = mesh_from_cells(nodes, cells, where=f"mesh of {where}")
    quality = cell_quality(mesh)
    if quality.min() < LEAST_QUALITY:
        raise InputError(
            "the mesh has a flat cell",
            where=where,
            value=f"mean ratio {quality.min():.3g} in cell {int(np.argmin(quality))}",
            limit=f"{LEAST_QUALITY:g} or more",
            remedy="change the sizing a little, or remove slivers from the surface",
        )
    return mesh
