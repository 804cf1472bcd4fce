"""Making a validated mesh from nodes and cells."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from thermo.errors import InputError

from ._boundary import boundary_faces
from ._geometry import mean_ratio, signed_volumes, squared_edges, triangle_normals
from ._mesh import Mesh
from ._topology import EDGES, FLIP

FLATTEST = 1e-5
"""Smallest mean ratio of a cell; a flatter one has no usable gradient in double precision."""

STRAIGHT = 1e-4
"""Largest distance of a middle node from the middle of its edge, in edge lengths."""


def _checked_arrays(
    nodes: np.ndarray, cells: np.ndarray, where: str
) -> tuple[Float[np.ndarray, "nodes 3"], Int[np.ndarray, "cells per_cell"]]:
    nodes, cells = np.asarray(nodes, float), np.asarray(cells)
    if nodes.ndim != 2 or nodes.shape[1] != 3 or len(nodes) == 0:
        raise InputError(
            "the nodes are not a list of positions",
            where=where,
            value=f"shape {nodes.shape}",
            limit="shape (nodes, 3) with nodes > 0",
            remedy="give three coordinates a node [m]",
        )
    if cells.ndim != 2 or cells.shape[1] not in (4, 10) or len(cells) == 0:
        raise InputError(
            "the cells are not tetrahedra",
            where=where,
            value=f"shape {cells.shape}",
            limit="shape (cells, 4) or (cells, 10) with cells > 0",
            remedy="give 4 or 10 node numbers a cell",
        )
    if not np.issubdtype(cells.dtype, np.integer):
        raise InputError(
            "the cells are not whole numbers",
            where=where,
            value=f"dtype {cells.dtype}",
            limit="an integer dtype",
            remedy="give node numbers counted from 0",
        )
    bad = np.flatnonzero(~np.isfinite(nodes).all(axis=1))
    if bad.size:
        raise InputError(
            "a node is not finite",
            where=where,
            value=f"node {bad[0]}: {nodes[bad[0]].tolist()}",
            limit="finite coordinates [m]",
            remedy="remove or repair the node",
        )
    if cells.min() < 0 or cells.max() >= len(nodes):
        raise InputError(
            "a cell names a node that is not there",
            where=where,
            value=f"numbers from {cells.min()} to {cells.max()}",
            limit=f"0 to {len(nodes) - 1}",
            remedy="count the nodes from 0",
        )
    return nodes, cells.astype(np.int32)


def _checked_regions(regions: np.ndarray | None, count: int, where: str) -> np.ndarray:
    if regions is None:
        return np.zeros(count, np.int32)
    regions = np.asarray(regions)
    if regions.shape != (count,) or not np.issubdtype(regions.dtype, np.integer):
        raise InputError(
            "the regions do not fit the cells",
            where=where,
            value=f"shape {regions.shape}, dtype {regions.dtype}",
            limit=f"one whole number for each of {count} cells",
            remedy="give the region number of every cell",
        )
    if regions.min() < 0:
        raise InputError(
            "a region number is negative",
            where=where,
            value=int(regions.min()),
            limit="0 or more",
            remedy="count the regions from 0",
        )
    return regions.astype(np.int32)


def _oriented(nodes: np.ndarray, cells: np.ndarray, where: str) -> np.ndarray:
    """Turn cells of negative volume; refuse flat ones."""
    quality = mean_ratio(nodes, cells)
    worst = int(np.argmin(np.abs(quality)))
    if abs(quality[worst]) < FLATTEST:
        raise InputError(
            "a cell has no volume",
            where=where,
            value=f"cell {worst}: mean ratio {abs(quality[worst]):.1e}, "
            f"volume {signed_volumes(nodes, cells[worst : worst + 1])[0]:.1e} m3",
            limit=f"mean ratio of at least {FLATTEST:g}",
            remedy="mesh the body again, or remove flat cells and doubled nodes",
        )
    flip = FLIP[: cells.shape[1]]
    return np.where((quality < 0.0)[:, None], cells[:, flip], cells)


def _require_straight(nodes: np.ndarray, cells: np.ndarray, where: str) -> None:
    """Refuse ten-node cells whose middle nodes lie off the middles of their edges."""
    middles = nodes[cells[:, EDGES]].mean(axis=2)
    off = np.linalg.norm(nodes[cells[:, 4:]] - middles, axis=-1)
    relative = off / np.sqrt(squared_edges(nodes, cells))
    cell, edge = np.unravel_index(int(np.argmax(relative)), relative.shape)
    if relative[cell, edge] > STRAIGHT:
        raise InputError(
            "a middle node is not in the middle of its edge",
            where=where,
            value=f"cell {cell}, edge {edge}: {off[cell, edge]:.2e} m off",
            limit=f"{STRAIGHT:g} of the edge length (cells have straight edges)",
            remedy="give the four corners of each cell and call promote(mesh)",
        )


def mesh_from_cells(
    nodes: np.ndarray,
    cells: np.ndarray,
    *,
    regions: np.ndarray | None = None,
    where: str = "mesh",
) -> Mesh:
    """Check nodes and cells, orient the cells and find the boundary.

    Nodes that no cell uses are dropped, which renumbers the others in their order. Cells inside
    out are turned.

    Arguments:
    - `nodes`: (nodes, 3) positions [m].
    - `cells`: (cells, 4) or (cells, 10) node numbers in VTK's order.
    - `regions`: (cells,) material region of each cell, 0 for all where left out.
    - `where`: what to call the mesh in messages.

    Raises `InputError` for wrong shapes, non-finite nodes, node numbers out of range, cells
    without volume, curved edges, overlapping cells and faces of more than two cells.
    """
    nodes, cells = _checked_arrays(nodes, cells, where)
    region_numbers = _checked_regions(regions, len(cells), where)
    used, inverse = np.unique(cells, return_inverse=True)
    nodes, cells = nodes[used], inverse.reshape(cells.shape).astype(np.int32)
    cells = _oriented(nodes, cells, where)
    if cells.shape[1] == 10:
        _require_straight(nodes, cells, where)
    faces, owners = boundary_faces(cells, where=where)
    normals, _ = triangle_normals(nodes, faces)
    return Mesh(nodes, cells.astype(np.int32), faces, owners, normals, region_numbers)
