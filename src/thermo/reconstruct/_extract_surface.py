"""The zero set of a distance as a closed surface of triangles."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import Final

import jax.numpy as jnp
import numpy as np
import trimesh
from jaxtyping import Array, Float, Int

from thermo.errors import InputError
from thermo.mesh import Surface, check_surface, crossing_pairs, simplified

from ._region import Region, from_unit, to_unit

_CHUNK: Final = 1 << 17
"""Places whose distance is asked for at a time [1]."""
_COARSE: Final = 4
"""Cells of the finer grid along the edge of one of the coarser [1]."""
_REACH: Final = 2.0
"""How far from zero a coarse corner may be, in diagonals of its cell, for the cell to be looked at
more closely [1]: where f is a distance one is enough; learned ones are off by less than half."""

Distance = Callable[[Float[Array, "points 3"]], Float[Array, " points"]]


def extract_surface(
    distance: Distance, region: Region, *, cells: int, triangles: int = 20000
) -> Surface:
    """The largest closed part of {f = 0} [m], turned outward, as `thermo.mesh` takes it.

    Marching cubes on `cells` [1] an edge of the region; distances are asked for near the zero set
    alone. Vertices are then moved to it by one step of Newton's method along grad f where that
    lies within a cell and folds nothing, and the surface is brought down to `triangles` [1] by
    `thermo.mesh.simplified`, or left as it is where that cannot be.

    Arguments: `distance`: f of places in halves of the region's edge [half an edge], negative
    inside. `region`: the cube [m]; where no photograph looks, such as below an object, f is
    anything, and the region's room is where the object ends.

    Raises `InputError` where f has no zero set, where the region's border cuts it, and where the
    packages of the extra `photographs` are missing.

    Source: paper, section 4.1 (checklist A6); Lorensen and Cline, SIGGRAPH 1987; Lewiner et al.,
    Journal of Graphics Tools 8 (2003) 1.
    """
    require_extra()
    # An extra of the package: imported where it is used.
    from skimage.measure import marching_cubes

    cells = _COARSE * max(2, round(cells / _COARSE))
    distance = _within_room(distance, region)
    values = _near_values(distance, cells)
    _require_surface(values)
    # A corner that lies on the surface would make triangles without area, and of them holes.
    least = 1e-3 * 2.0 / cells
    values = np.where(np.abs(values) < least, np.where(values < 0, -least, least), values)
    corners, faces, _, _ = marching_cubes(values, 0.0)
    unit = 2.0 * corners.astype(float) / cells - 1.0
    # The library turns triangles towards falling values; f rises outward.
    whole = trimesh.Trimesh(unit, faces[:, ::-1], process=False)
    largest = max(whole.split(only_watertight=False), key=lambda part: part.area)
    corners, faces = np.asarray(largest.vertices), np.asarray(largest.faces)
    moved = _on_zero(distance, corners, 2.0 / cells)
    if region.room is not None:
        moved = np.clip(moved, *to_unit(region, region.room))
    vertices = from_unit(region, _unfolded(moved, corners, faces))
    return _brought_down(Surface(vertices, faces.astype(np.int64)), region, triangles)


def _brought_down(whole: Surface, region: Region, triangles: int) -> Surface:
    """The whole surface of few triangles [m], or as it is where it would not stay closed."""
    where = "reconstructed surface"
    try:
        return _checked(simplified(whole, most=triangles, target=triangles, where=where), region)
    except InputError:
        return _checked(whole, region)


def _checked(surface: Surface, region: Region) -> Surface:
    vertices = surface.vertices
    if region.room is not None:
        # Simplified edges of what the room cuts off stand out of it by rounding and little more.
        vertices = np.clip(vertices, region.room[0], region.room[1])
    return check_surface(
        Surface(vertices, surface.triangles), where="reconstructed surface",
        largest=4.0 * region.half, smallest=1e-3 * region.half,
    )  # fmt: skip


def _within_room(distance: Distance, region: Region) -> Distance:
    """f, or how far a place is out of the region's room where that is more."""
    if region.room is None:
        return distance
    low, high = to_unit(region, region.room)
    middle, half = jnp.asarray(0.5 * (low + high)), jnp.asarray(0.5 * (high - low))

    def bounded(places: Float[Array, "points 3"]) -> Float[Array, " points"]:
        return jnp.maximum(distance(places), jnp.max(jnp.abs(places - middle) - half, axis=1))

    return bounded


def require_extra() -> None:
    """Refuse to begin without what the surface is made with in the end.

    Raises `InputError`.
    """
    missing = [name for name in ("igl", "skimage") if find_spec(name) is None]
    if missing:
        raise InputError(
            "surfaces from photographs need extra packages", where="reconstruction",
            value=f"no {' and no '.join(missing)}", limit="the extra `photographs`",
            remedy="pip install 'thermofield[photographs]'",
        )  # fmt: skip


def _near_values(distance: Distance, cells: int) -> Float[np.ndarray, "x y z"]:
    """f on the corners of the fine grid; far from the surface that of a coarse corner."""
    count = cells // _COARSE
    coarse = _on_grid(distance, np.linspace(-1.0, 1.0, count + 1))
    near = np.abs(coarse) < _REACH * np.sqrt(3.0) * 2.0 / count
    # A cell is looked at where any of its corners is near, and all of it with its border.
    wanted = np.zeros((count,) * 3, bool)
    for shift in np.ndindex(2, 2, 2):
        wanted |= near[tuple(slice(s, s + count) for s in shift)]
    # The nearest coarse corner: its sign is that of all corners about it.
    values = coarse[np.ix_(*(np.round(np.arange(cells + 1) / _COARSE).astype(int),) * 3)]
    fine = np.zeros(values.shape, bool)
    for shift in np.ndindex(*(_COARSE + 1,) * 3):
        fine[tuple(slice(s, s + _COARSE * count, _COARSE) for s in shift)] |= wanted
    places = 2.0 * np.argwhere(fine) / cells - 1.0
    values[fine] = _at(distance, places)
    return values


def _on_grid(distance: Distance, axis: np.ndarray) -> Float[np.ndarray, "x y z"]:
    places = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
    return _at(distance, places.reshape(-1, 3)).reshape(places.shape[:3])


def _at(distance: Distance, places: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, " points"]:
    """f at many places, a chunk of one size at a time, so that one program serves all."""
    parts = []
    for start in range(0, len(places), _CHUNK):
        rows = np.minimum(np.arange(start, start + _CHUNK), len(places) - 1)
        parts.append(np.asarray(distance(jnp.asarray(places[rows])), float))
    return np.concatenate(parts)[: len(places)]


def _on_zero(
    distance: Distance, vertices: Float[np.ndarray, "vertices 3"], cell: float
) -> Float[np.ndarray, "vertices 3"]:
    """Vertices moved by -f grad f / |grad f|^2, by central differences of a quarter of a cell."""
    step = 0.25 * cell
    value = _at(distance, vertices)
    slope = np.stack(
        [
            (_at(distance, vertices + step * way) - _at(distance, vertices - step * way)) / step / 2
            for way in np.eye(3)
        ],
        axis=1,
    )
    square = np.maximum(np.sum(slope**2, axis=1), 1e-12)
    moved = -(value / square)[:, None] * slope
    size = np.linalg.norm(moved, axis=1, keepdims=True)
    return vertices + np.where(size < 0.5 * cell, moved, 0.0)


def _unfolded(
    moved: Float[np.ndarray, "vertices 3"],
    stood: Float[np.ndarray, "vertices 3"],
    faces: Int[np.ndarray, "triangles 3"],
) -> Float[np.ndarray, "vertices 3"]:
    """Vertices that were moved, but where triangles would then pass through each other.

    At a crease grad f is neither side's, and a step along it may fold the surface. Triangles of
    marching cubes lie in cells of their own: they pass through no other.
    """
    vertices = moved.copy()
    while len(pairs := crossing_pairs(vertices, faces)):
        back = np.unique(faces[pairs])
        if np.array_equal(vertices[back], stood[back]):
            break
        vertices[back] = stood[back]
    return vertices


def _require_surface(values: Float[np.ndarray, "x y z"]) -> None:
    if values.min() >= 0 or values.max() <= 0:
        raise InputError(
            "there is no surface in the region", where="reconstruction",
            value=f"distances of {values.min():.3g} to {values.max():.3g} half edges",
            limit="places inside and outside",
            remedy="check masks and poses with what the checks before said, or train for longer",
        )  # fmt: skip
    sides = [values[0], values[-1], values[:, 0], values[:, -1], values[:, :, 0], values[:, :, -1]]
    if min(float(side.min()) for side in sides) < 0:
        raise InputError(
            "the border of the region cuts the surface", where="reconstruction",
            value="places inside the object on the border", limit="an object within the region",
            remedy="give a larger box, or masks that leave out what the object stands on",
        )  # fmt: skip
