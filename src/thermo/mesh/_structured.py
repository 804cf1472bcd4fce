"""Splitting structured blocks into tetrahedra."""

from __future__ import annotations

from itertools import permutations

import numpy as np
from jaxtyping import Int

from thermo.errors import InputError


def lattice_cells(shape: tuple[int, int, int]) -> Int[np.ndarray, "cells 4"]:
    """Six tetrahedra (Kuhn's split) for each brick of a lattice of `shape` nodes.

    Nodes are numbered with the last axis running fastest. All bricks are split alike, so that
    neighbours share their diagonals. Volumes may have either sign.
    """
    number = np.arange(np.prod(shape)).reshape(shape)
    cells = []
    for path in permutations(range(3)):
        corner = np.zeros(3, int)
        corners = [corner.copy()]
        for axis in path:
            corner[axis] += 1
            corners.append(corner.copy())
        cells.append(np.stack([_shifted(number, step).ravel() for step in corners], axis=1))
    return np.stack(cells, axis=1).reshape(-1, 4)


def _shifted(number: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Node numbers at one corner of every brick."""
    slices = tuple(
        slice(int(s), size - 1 + int(s)) for s, size in zip(step, number.shape, strict=True)
    )
    return number[slices]


def require_positive(name: str, value: float | int) -> None:
    """Refuse a length or count that is not positive and finite.

    Raises `InputError` naming the argument.
    """
    if not (np.isfinite(value) and value > 0):
        raise InputError(
            f"{name} is not positive",
            where=name,
            value=value,
            limit="a finite number above 0",
            remedy=f"give a positive {name}",
        )
