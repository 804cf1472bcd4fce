"""Distances along the surface, control points on it, and which of them are neighbours."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from thermo.errors import InputError
from thermo.mesh import Mesh


@final
class ControlPoints(eqx.Module):
    """Sparse points on the surface.

    - `points`: (controls, 3) [m]; `vertex`: their surface vertices, (controls,).
    - `distance`: along the surface to every surface vertex, (controls, vertices) [m].
    - `pairs`: neighbours on the surface, (pairs, 2).
    """

    points: Float[np.ndarray, "controls 3"]
    vertex: Int[np.ndarray, " controls"]
    distance: Float[np.ndarray, "controls vertices"]
    pairs: Int[np.ndarray, "pairs 2"]


def surface_vertices(
    mesh: Mesh,
) -> tuple[Int[np.ndarray, " vertices"], Int[np.ndarray, "faces 3"]]:
    """Corner nodes on the boundary, and the faces [1] in their numbering."""
    nodes, faces = np.unique(mesh.faces[:, :3], return_inverse=True)
    return nodes, faces.reshape(-1, 3)


def surface_edges(mesh: Mesh) -> Int[np.ndarray, "edges 2"]:
    """Edges between surface vertices, each once, in the numbering [1] of `surface_vertices`."""
    _, faces = surface_vertices(mesh)
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(edges, axis=0)


def place_control_points(
    mesh: Mesh, count: int, *, seed: int = 0, active: Bool[np.ndarray, " vertices"] | None = None
) -> ControlPoints:
    """Spread control points over the surface, each as far from the others as can be.

    Farthest-point sampling with distances along the surface, so that the two sides of a thin wall
    are far apart. Where `active` is given, distances count three times as much there, so that the
    active part holds about nine times as many points for its area.

    Arguments:

    - `count`: number of points [1], at most the number of surface vertices.
    - `seed`: of the first point.
    - `active`: for each surface vertex, whether it takes part in the thermal process.

    Raises `InputError` where `count` is below 1.

    Source: paper, appendix B.5 (checklist C1, C6, C8).
    """
    if count < 1:
        raise InputError(
            "a field needs control points", where="count", value=count,
            limit="a whole number above 0", remedy="leave it at its default",
        )  # fmt: skip
    nodes, _ = surface_vertices(mesh)
    place = mesh.nodes[nodes]
    edges = surface_edges(mesh)
    length = np.linalg.norm(place[edges[:, 0]] - place[edges[:, 1]], axis=1)
    graph = csr_matrix((length, (edges[:, 0], edges[:, 1])), shape=(len(nodes),) * 2)
    # Parts that are not connected along the surface are far apart, yet not infinitely.
    beyond = 2 * float(np.linalg.norm(np.ptp(place, axis=0)))
    count = min(count, len(nodes))
    weight = np.ones(len(nodes)) if active is None else np.where(active, 3.0, 1.0)
    start = np.flatnonzero(weight == weight.max())
    chosen = [int(np.random.default_rng(seed).choice(start))]
    rows: list[np.ndarray] = []
    nearest = np.full(len(nodes), np.inf)
    while True:
        row = dijkstra(graph, directed=False, indices=chosen[-1])
        row = np.minimum(row, beyond)
        rows.append(row)
        nearest = np.minimum(nearest, row)
        if len(chosen) == count:
            break
        chosen.append(int(np.argmax(nearest * weight)))
    distance = np.stack(rows)
    owner = distance.argmin(0)
    meeting = np.sort(owner[edges], axis=1)
    pairs = np.unique(meeting[meeting[:, 0] != meeting[:, 1]], axis=0)
    vertex = np.asarray(chosen)
    return ControlPoints(place[vertex], vertex, distance, pairs.reshape(-1, 2))
