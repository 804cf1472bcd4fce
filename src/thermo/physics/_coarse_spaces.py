"""Coarser spaces of a mesh, in which a solver meets what is smooth.

The corners of quadratic cells hold what is linear in each cell; parts of the body, each a few cells
wide, hold what is constant in each part.
"""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from thermo.mesh import Mesh, cell_volumes
from thermo.physics._shape import CELL_EDGES, reference_mass

LEAST_NODES = 5000
"""Nodes [1] below which a product is so cheap that coarser spaces are not worth compiling."""

PAYS = 60.0
"""Conducted over stored heat of a corner in the longest step [1], on average, from which they are.

Quadratic cells take half the time there and a fourth or fifth of it in longer steps, linear ones
about as long and a third (`benchmarks/coarse_spaces.py`); a program compiles a second longer.
"""

IN_A_PART, MOST_PARTS = 16, 256
"""About how many corners share a part at the least, and the most parts [1].

A dense matrix of the parts is inverted in each step, so that they are to be few.
"""


@final
class CoarseSpaces(eqx.Module):
    """Corners and parts of a mesh.

    - `ends`: of each node the corners that it lies between, (nodes, 2), twice the same for a
      corner; None where all nodes are corners.
    - `cells`: the corners of each cell, (cells, 4).
    - `part`: of each corner, (corners,).
    - `parts`: how many there are [1].
    """

    ends: Int[Array | np.ndarray, "nodes 2"] | None
    cells: Int[Array | np.ndarray, "cells 4"]
    part: Int[Array | np.ndarray, " corners"]
    parts: int = eqx.field(static=True)

    def corners(self, values: Float[Array, "nodes *batch"]) -> Float[Array, "corners *batch"]:
        """What nodes hold [J], shared out to the corners that they lie between."""
        if self.ends is None:
            return values
        shared = jnp.zeros((len(self.part), *values.shape[1:]), values.dtype)
        return shared.at[self.ends].add(0.5 * values[:, None], mode="promise_in_bounds")

    def nodes(self, values: Float[Array, "corners *batch"]) -> Float[Array, "nodes *batch"]:
        """Linear between the corners [K]: the transpose of `corners`."""
        if self.ends is None:
            return values
        first, second = (values.at[end].get(mode="promise_in_bounds") for end in self.ends.T)
        return 0.5 * (first + second)

    def sums(self, values: Float[Array, "corners *batch"]) -> Float[Array, "parts *batch"]:
        """Sums of what corners hold [J] over each part."""
        none = jnp.zeros((self.parts, *values.shape[1:]), values.dtype)
        return none.at[self.part].add(values, mode="promise_in_bounds")


def coarse_spaces(
    mesh: Mesh, gradient: Float[np.ndarray, "cells 4 3"], reach: float
) -> CoarseSpaces | None:
    """The coarser spaces of a mesh [m]; None where they do not pay.

    `gradient` as in `Discretisation` [m^1/2]; `reach` as for `discretise` [m2].
    """
    if len(mesh.nodes) < LEAST_NODES:
        return None
    conducted, stored = np.zeros((2, len(mesh.nodes)))
    squares = np.sum(gradient**2, axis=2)
    np.add.at(conducted, mesh.cells[:, :4], squares)
    np.add.at(stored, mesh.cells[:, :4], cell_volumes(mesh)[:, None] * reference_mass(1)[0, 0])
    if reach * np.mean(conducted[stored > 0] / stored[stored > 0]) < PAYS:
        return None
    corners, cells = np.unique(mesh.cells[:, :4], return_inverse=True)
    cells = cells.reshape(-1, 4).astype(np.int32)
    ends = None
    if mesh.order > 1:
        ends = np.empty((len(mesh.nodes), 2), np.int32)
        ends[corners] = np.arange(len(corners))[:, None]
        ends[mesh.cells[:, 4:]] = cells[:, np.asarray(CELL_EDGES)]
    halvings = int(np.log2(min(MOST_PARTS, len(corners) / IN_A_PART)))
    return CoarseSpaces(ends, cells, halved(mesh.nodes[corners], halvings), 2**halvings)


def halved(points: Float[np.ndarray, "points 3"], times: int) -> Int[np.ndarray, " points"]:
    """The part of each point [m], halved again and again across where a part is longest."""
    part = np.zeros(len(points), np.int32)
    for _ in range(times):
        finer = np.empty_like(part)
        for one in range(part.max() + 1):
            inside = np.flatnonzero(part == one)
            axis = int(np.argmax(np.ptp(points[inside], axis=0)))
            inside = inside[np.argsort(points[inside, axis], kind="stable")]
            middle = len(inside) // 2
            finer[inside[:middle]], finer[inside[middle:]] = 2 * one, 2 * one + 1
        part = finer
    return part
