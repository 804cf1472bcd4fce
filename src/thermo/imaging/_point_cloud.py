"""Clouds of points: from files, and whether they may show an object."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

import numpy as np
import trimesh
from jaxtyping import Float

from thermo.errors import InputError
from thermo.mesh import Surface
from thermo.observe import LENGTH, check_number, read_npz, read_table, real_array

_FEWEST: Final = 12
"""Points, twice as many as there are numbers of a pose [1]."""

_SMALLEST: Final = 1 / 8
"""Span of a cloud over the object's that tells a pose at the least: more than the tenth that is
left of millimetres taken for centimetres, which are nearest of all units but the inch [1]."""

_AROUND: Final = 0.25
"""How far about the object's box its points may lie, over its size, before they are matched [1]."""


_MISTAKEN: Final = (
    ("m", "mm", 1e3), ("m", "cm", 1e2), ("cm", "mm", 1e1),
    ("mm", "m", 1e-3), ("cm", "m", 1e-2), ("mm", "cm", 1e-1),
)  # fmt: skip
"""Units of points that are stated in place of others, and how much too large they make them [1]."""


def read_points(path: Path | str, *, unit: str | float) -> Float[np.ndarray, "points 3"]:
    """Points [m] of a file.

    Arguments:

    - `path`: PLY, of which the vertices count; XYZ or TXT, a line of numbers a point, x, y and z
      first; CSV with columns `x`, `y`, `z`, which may state their unit as `x_mm`; NPY (points, 3);
      NPZ with `points` (points, 3).
    - `unit`: of its coordinates: "m", "cm", "mm" or "inch", or the length of one [m].

    Raises `InputError` for a file that is absent, empty or no such file, for units that are not
    known or that are not the header's, for fewer than 12 points and for those that are not finite.
    """
    path = Path(path)
    metres = _metres(unit, path)
    if not path.is_file():
        raise _unreadable(path, "a folder" if path.is_dir() else "no such file")
    reader = _READERS.get(path.suffix.casefold())
    if reader is None:
        raise _unreadable(path, f"a name that ends in {path.suffix or 'nothing'}")
    return as_cloud(reader(path, metres), where=str(path))


def as_cloud(points: object, *, where: str) -> Float[np.ndarray, "points 3"]:
    """Points [m] as an array (points, 3).

    Raises `InputError` for fewer than 12 of them, and for those that are not finite.
    """
    cloud = real_array(points, where=where, quantity="points [m]")
    if cloud.ndim != 2 or cloud.shape[1] != 3 or len(cloud) < _FEWEST:
        raise InputError(
            "this is no cloud of points", where=where, value=f"shape {cloud.shape}",
            limit=f"shape (points, 3), at least {_FEWEST} points",
            remedy="give one row of x, y, z a point",
        )  # fmt: skip
    bad = np.flatnonzero(~np.isfinite(cloud).all(axis=1))
    if bad.size:
        raise InputError(
            "a point is not finite", where=where,
            value=f"{bad.size} points, the first is point {bad[0]}: {cloud[bad[0]].tolist()}",
            limit="finite metres", remedy="drop points without a place",
        )  # fmt: skip
    return cloud


def check_cloud(surface: Surface, points: Float[np.ndarray, "points 3"], *, where: str) -> None:
    """Refuse a cloud [m] that cannot show a surface [m] to which it is near.

    Half of the points at least are to lie on the surface, after a motion by a tenth of its size. So
    along each axis the shortest span that holds half of them is no longer than the surface's
    diagonal, and half of them lie within a quarter of that about its box.

    Raises `InputError` for a cloud of another unit or place.
    """
    size = surface.diagonal()
    ordered, half = np.sort(points, axis=0), len(points) // 2
    most = float((ordered[half:] - ordered[: len(points) - half]).min(axis=0).max())
    low, high = np.quantile(points, [0.05, 0.95], axis=0)
    span = float(np.linalg.norm(high - low))
    if most > size or span < _SMALLEST * size:
        large = most > size
        raise InputError(
            "the points are of another size than the surface", where=where,
            value=f"half of them over {most:.3g} m at the least" if large else
            f"most of them within {span:.3g} m",
            limit=f"a part of a surface of {size:.3g} m, from an eighth of it to the whole",
            remedy=f"they span {span / size:.2g} times its size: {_other_unit(span / size)}, look "
            "whether the file is of this object, and cut away what is not the object",
        )  # fmt: skip
    box = np.stack([surface.vertices.min(axis=0), surface.vertices.max(axis=0)])
    around = _AROUND * size
    near = (points > box[0] - around).all(axis=1) & (points < box[1] + around).all(axis=1)
    if near.mean() < 0.5:
        middles = _place(np.median(points, axis=0)), _place(box.mean(axis=0))
        raise InputError(
            "the points are elsewhere than the surface", where=where,
            value=f"{100 * near.mean():.0f} % of them within {around:.2g} m of its box; their "
            f"middle is at {middles[0]} m, its own at {middles[1]} m",
            limit="half of them, in the world of the cameras",
            remedy="cut away what is not the object; look whether points, cameras and surface have "
            "the same axes and origin, and bring the surface nearer",
        )  # fmt: skip


def _other_unit(times: float) -> str:
    """Which unit would do where a cloud spans so many times the object's size [1]."""
    near = [
        f"as if {given} stood for {meant}" for given, meant, factor in _MISTAKEN
        if 0.5 < times / factor < 2.0
    ]  # fmt: skip
    return (f"{near[0]}; state" if near else "state") + " another unit of the points or the surface"


def _metres(unit: str | float, path: Path) -> float:
    if not isinstance(unit, str):
        return check_number(unit, where=str(path), quantity="length of the unit [m]", above=0.0)
    if unit not in LENGTH:
        raise InputError(
            "the unit is not known", where=str(path), value=unit, limit=", ".join(LENGTH),
            remedy="state the unit of the points' coordinates",
        )  # fmt: skip
    return LENGTH[unit][0]


def _ply(path: Path, metres: float) -> np.ndarray:
    try:
        loaded = trimesh.load(path, process=False)
    # trimesh's readers raise whatever they meet (struct, index, key errors).
    except Exception as error:
        raise _unreadable(path, f"{type(error).__name__}: {str(error)[:160]}") from error
    points = np.asarray(getattr(loaded, "vertices", np.zeros((0, 3))), float)
    return metres * points.reshape(-1, 3)


def _lines(path: Path, metres: float) -> np.ndarray:
    try:
        rows = np.loadtxt(path, ndmin=2, encoding="utf-8-sig")
    except (ValueError, OSError) as error:
        raise _unreadable(path, " ".join(str(error).split())[:160]) from error
    return metres * rows[:, :3]


def _table(path: Path, metres: float) -> np.ndarray:
    table = read_table(path)
    columns = table.bases(dict.fromkeys("xyz", LENGTH))
    absent = [axis for axis in "xyz" if axis not in columns]
    if absent:
        raise _unreadable(path, f"columns {', '.join(table.header)}")
    found = []
    for axis in "xyz":
        plain = table.numbers(columns[axis], {})
        stated = table.numbers(columns[axis], LENGTH)
        # A header without a unit leaves the numbers as they are; one with metres does as well.
        named = table.header[columns[axis]].casefold() != axis
        if named and not np.allclose(stated, metres * plain, rtol=1e-6):
            raise InputError(
                "the header names another unit than is stated", where=str(path),
                value=f"{table.header[columns[axis]]}; {metres:g} m are stated", limit="one unit",
                remedy="state the header's unit",
            )  # fmt: skip
        found.append(metres * plain)
    return np.stack(found, axis=1)


def _npy(path: Path, metres: float) -> np.ndarray:
    try:
        points = np.load(path, allow_pickle=False)
    except (ValueError, OSError, EOFError, SyntaxError) as error:
        raise _unreadable(path, " ".join(str(error).split())[:160]) from error
    return metres * real_array(points, where=str(path), quantity="points")


def _npz(path: Path, metres: float) -> np.ndarray:
    points = read_npz(path, required=("points",))["points"]
    return metres * real_array(points, where=str(path), quantity="points")


_READERS: Final[Mapping[str, Callable[[Path, float], np.ndarray]]] = {
    ".ply": _ply, ".xyz": _lines, ".txt": _lines, ".csv": _table, ".npy": _npy, ".npz": _npz,
}  # fmt: skip


def _unreadable(path: Path, value: str) -> InputError:
    return InputError(
        "this is no file of points that can be read", where=str(path), value=value,
        limit="PLY; XYZ or TXT, x y z a line; CSV with columns x, y, z; NPY; NPZ with `points`",
        remedy="check the name, or export the points again in one of these formats",
    )  # fmt: skip


def _place(point: Float[np.ndarray, "3"]) -> str:
    return f"[{', '.join(f'{one:.3g}' for one in point)}]"
