"""Surfaces from files."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
import trimesh

from thermo.errors import InputError

from ._check_surface import check_surface
from ._surface import Surface

METRES: Final = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}
"""Metres in one unit."""


def read_surface(
    path: str | Path,
    *,
    unit: str = "m",
    largest: float | int = 2.0,
    smallest: float | int = 1e-4,
) -> Surface:
    """Read, scale, repair and check a closed triangle surface.

    Arguments:
    - `path`: any file that trimesh reads as triangles (PLY, STL, OBJ, OFF, GLB).
    - `unit`: unit of the coordinates in the file: "m", "cm", "mm" or "inch".
    - `largest`, `smallest`: limits of the longest side of the box [m].

    Raises `InputError` where the file is missing or unreadable, the unit unknown, and for all
    that `check_surface` refuses.
    """
    path = Path(path)
    if unit not in METRES:
        raise InputError(
            "the unit is not known",
            where=str(path),
            value=unit,
            limit=", ".join(METRES),
            remedy="state the unit of the file's coordinates",
        )
    if not path.is_file():
        raise InputError(
            "the surface file is not there",
            where=str(path),
            value="no such file",
            limit="a readable file",
            remedy="check the path",
        )
    vertices, triangles = _load(path)
    surface = Surface(vertices * METRES[unit], triangles)
    return check_surface(surface, where=str(path), largest=largest, smallest=smallest)


def _load(path: Path) -> tuple[np.ndarray, np.ndarray]:
    try:
        loaded = trimesh.load_mesh(path, process=False)
    # trimesh's readers raise whatever they meet (struct, index, key, JSON errors).
    except Exception as error:
        raise InputError(
            "the surface cannot be read",
            where=str(path),
            value=f"{type(error).__name__}: {str(error)[:200]}",
            limit="a triangle surface that trimesh reads",
            remedy="export it again as PLY, STL or OBJ",
        ) from error
    triangles = np.asarray(getattr(loaded, "faces", np.zeros((0, 3), int)))
    vertices = np.asarray(getattr(loaded, "vertices", np.zeros((0, 3))), float)
    return vertices.reshape(-1, 3), triangles.reshape(-1, 3).astype(np.int64)
