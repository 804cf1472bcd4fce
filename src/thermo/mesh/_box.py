"""Structured mesh of a box."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from thermo.errors import InputError

from ._build import mesh_from_cells
from ._mesh import Mesh
from ._structured import lattice_cells


def box_mesh(
    lengths: Sequence[float | int],
    divisions: Sequence[int],
    *,
    origin: Sequence[float | int] = (0.0, 0.0, 0.0),
) -> Mesh:
    """TET4 mesh of a box: every brick of a regular lattice is split into six cells.

    Arguments:
    - `lengths`: sides of the box along x, y, z [m].
    - `divisions`: number of bricks along x, y, z.
    - `origin`: the corner with the smallest coordinates [m].

    Raises `InputError` for lengths that are not positive or divisions below 1.
    """
    if not (np.isfinite(lengths).all() and min(lengths) > 0.0):
        raise InputError(
            "a side of the box is not positive",
            where="lengths",
            value=lengths,
            limit="above 0 m",
            remedy="give the three sides in metres",
        )
    if min(divisions) < 1:
        raise InputError(
            "a side of the box has no bricks",
            where="divisions",
            value=divisions,
            limit="1 or more",
            remedy="divide each side at least once",
        )
    axes = [
        start + np.linspace(0.0, length, count + 1)
        for start, length, count in zip(origin, lengths, divisions, strict=True)
    ]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    x, y, z = divisions
    return mesh_from_cells(nodes, lattice_cells((x + 1, y + 1, z + 1)), where="box_mesh")
