"""Finding the boundary of a set of tetrahedra."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Int

from thermo.errors import InputError

from ._topology import face_columns


def _turns_even(triangles: Int[np.ndarray, "faces 3"]) -> Bool[np.ndarray, " faces"]:
    """Whether sorting the three corners is an even permutation, that is, keeps the turn."""
    a, b, c = triangles.T
    swaps = (a > b).astype(int) + (a > c) + (b > c)
    return swaps % 2 == 0


def boundary_faces(
    cells: Int[np.ndarray, "cells per_cell"], *, where: str
) -> tuple[Int[np.ndarray, "faces per_face"], Int[np.ndarray, " faces"]]:
    """The faces that one cell alone owns, turned outward, and their owners.

    The cells must have positive volume. Raises `InputError` where three cells or more share a
    face, or where two cells lie on the same side of one.
    """
    columns = face_columns(1 if cells.shape[1] == 4 else 2)
    every = cells[:, columns].reshape(-1, columns.shape[1])
    corners = every[:, :3]
    even = _turns_even(corners)
    ordered = np.sort(corners, axis=1).astype(np.int64)
    order = np.lexsort(ordered.T[::-1])
    ordered, even = ordered[order], even[order]
    first = np.ones(len(order), bool)
    first[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    starts = np.flatnonzero(first)
    counts = np.diff(np.append(starts, len(order)))
    if counts.max() > 2:
        bad = ordered[starts[np.argmax(counts)]]
        raise InputError(
            "a face is shared by more than two cells",
            where=where,
            value=f"face of nodes {bad.tolist()} in {counts.max()} cells",
            limit="at most 2 cells",
            remedy="remove the doubled or overlapping cells",
        )
    pairs = starts[counts == 2]
    same_side = even[pairs] == even[pairs + 1]
    if same_side.any():
        bad = ordered[pairs[same_side][0]]
        raise InputError(
            "two cells overlap",
            where=where,
            value=f"both on one side of the face of nodes {bad.tolist()}",
            limit="cells on opposite sides of their common face",
            remedy="remove the doubled or overlapping cells",
        )
    single = np.sort(order[starts[counts == 1]])
    return every[single].astype(np.int32), (single // 4).astype(np.int32)
