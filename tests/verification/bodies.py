"""Slabs and boxes as 3-D bodies with adiabatic sides, and how to run them."""

from __future__ import annotations

from collections.abc import Sequence

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from thermo.mesh import box_mesh, faces_towards, promote
from thermo.physics import Discretisation, ReadOut, TimeGrid, discretise, solve_heat
from thermo.physics.effects import History, PrescribedTemperature

simulate = eqx.filter_jit(solve_heat)

FRONT, BACK = (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)


def slab(length: float, cells: int, *, order: int = 2) -> Discretisation:
    """Slab from x = 0, one brick across; TET10, or TET4 with `order` 1."""
    side = 2 * length / cells
    mesh = box_mesh((length, side, side), (cells, 1, 1))
    return discretise(mesh if order == 1 else promote(mesh))


def at_sections(space: Discretisation, places: Sequence[float]) -> ReadOut:
    """Mean over the nodes of each section x = place of a slab."""
    x = space.mesh.nodes[:, 0]
    nodes = [np.flatnonzero(np.abs(x - place) < 1e-9) for place in places]
    nodes = np.stack(nodes).astype(np.int32)
    return ReadOut(nodes, np.full(nodes.shape, 1 / nodes.shape[1]))


def at_points(space: Discretisation, points: Sequence[Sequence[float]]) -> ReadOut:
    """The nodes that lie at the given points."""
    away = np.linalg.norm(space.mesh.nodes[None] - np.asarray(points)[:, None], axis=2)
    assert away.min(1).max() < 1e-9
    nodes = away.argmin(1)[:, None].astype(np.int32)
    return ReadOut(nodes, np.ones(nodes.shape))


def on_faces_towards(space: Discretisation, *directions: Sequence[float], value: float = 1.0):
    """`value` on the faces that look along one of the directions, zero on the others."""
    level = np.zeros(len(space.mesh.faces))
    for direction in directions:
        level[faces_towards(space.mesh, direction)] = value
    return jnp.asarray(level)


def everywhere(space: Discretisation, value: float):
    return jnp.full(len(space.mesh.nodes), float(value))


def in_cells(space: Discretisation, value: float):
    return jnp.full(len(space.mesh.cells), float(value))


def constant(value: float) -> History:
    return History(jnp.zeros(1), jnp.full(1, float(value)))


def held(space: Discretisation, *patches: tuple[np.ndarray, History]) -> PrescribedTemperature:
    """Prescribed histories on the nodes chosen by each mask."""
    number = np.full(len(space.mesh.nodes), -1)
    for count, (mask, _) in enumerate(patches):
        number[mask] = count
    return PrescribedTemperature(jnp.asarray(number), tuple(history for _, history in patches))


def growing_steps(frames: Sequence[float], first: float, ratio: float) -> TimeGrid:
    """Steps that start with `first` and grow by `ratio`, cut at the frames."""
    times = np.asarray(frames, float)
    ends, size = [0.0], first
    for frame in times[times > 0]:
        while ends[-1] + 1.3 * size < frame:
            ends.append(ends[-1] + size)
            size *= ratio
        ends.append(frame)
    edges = np.array(ends)
    where = np.searchsorted(edges, times).astype(np.int32)
    return TimeGrid(edges[:-1], np.diff(edges), where, times)
