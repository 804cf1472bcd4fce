"""Two values with a boundary between them whose place is found."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int
from scipy.interpolate import RBFInterpolator

from thermo.fields._cut_simplex import share_above
from thermo.fields._field import AbstractField
from thermo.fields._head import AbstractHead
from thermo.fields._quantity import Quantity
from thermo.fields._surface_graph import ControlPoints, surface_edges, surface_vertices
from thermo.mesh import Mesh

# Shift of the boundary at a control for one unit of its parameter, in distances to its neighbours.
SHIFT = 0.4

# Controls up to this many distances to a neighbour away from the boundary can shift it.
REACH = 1.5

# Barycentric points of equal weight, exact to the second degree, on a tetrahedron and a triangle.
CELL_POINTS = np.full((4, 4), 0.1381966011250105) + np.eye(4) * 0.4472135954999579
FACE_POINTS = np.full((3, 3), 1 / 6) + np.eye(3) / 2


@final
class Boundary(eqx.Module):
    """Two materials apart from any mesh.

    - `points`: (controls, 3) [m]; `heights`: how far above the boundary they are, (controls,) [m].
    - `levels`: values far below and far above it, (2,) [in the quantity's unit].
    """

    points: Float[np.ndarray, "controls 3"]
    heights: Float[np.ndarray, " controls"]
    levels: Float[np.ndarray, "2"]


@final
class TwoMaterialField(AbstractField):
    """log phi = mean over a cell or face of [log low + (log high - log low) (1 + tanh(u)) / 2].

    u is a level-set function, zero on the boundary and one at a transition's half-width from it:
    u = base + weight s, with one shift s a control near the boundary. Cells that the boundary
    cuts take the share of both sides, to the accuracy of four points a cell.

    - `levels`: unconstrained numbers of both values, (2,) [1]; `head`: their map to values.
    - `shifts`: s, (controls,) [1].
    - `cell_base` (cells, 4), `cell_weight` (cells, 4, controls) [1]; on faces three points.
    - `gain`: of a control's shift on its own u [1].
    - `width`: half the transition, that is one unit of u [m].
    - `points` (all, 3) [m], `heights` (all,) [1]: u before all shifts at all control points;
      `near`: which of them shift.

    Source: Aghasi, Kilmer, Miller, SIAM J. Imaging Sciences 4 (2011) 618, parametric level sets.
    """

    quantity: Quantity = eqx.field(static=True)
    head: AbstractHead
    levels: Float[Array, "2"]
    shifts: Float[Array, " controls"]
    cell_base: Float[Array, "cells 4"]
    cell_weight: Float[Array, "cells 4 controls"]
    face_base: Float[Array, "faces 3"]
    face_weight: Float[Array, "faces 3 controls"]
    gain: Float[Array, ""]
    width: Float[Array, ""]
    points: Float[np.ndarray | Array, "all 3"]
    heights: Float[np.ndarray | Array, " all"]
    near: Int[np.ndarray | Array, " controls"]

    def parameters(self) -> dict[str, Float[Array, "..."]]:
        """Both levels and the shifts [1]."""
        return {"levels": self.levels, "shifts": self.shifts}

    def with_parameters(self, parameters: dict[str, Float[Array, "..."]]) -> TwoMaterialField:
        """The same field with other levels and shifts [1]."""
        new = (parameters["levels"], parameters["shifts"])
        return eqx.tree_at(lambda field: (field.levels, field.shifts), self, new)

    def boundary(self) -> Boundary:
        """The field apart from its mesh: points and their heights [m], and both values."""
        heights = np.array(self.heights)
        heights[np.asarray(self.near)] += np.asarray(self.gain * self.shifts)
        levels = np.asarray(self.head.value(self.levels))
        return Boundary(np.asarray(self.points), heights * float(self.width), levels)

    def _between(self, height: Float[Array, "*any"]) -> Float[Array, "*any"]:
        low, high = jnp.log(self.head.value(self.levels))
        return low + (high - low) * 0.5 * (1 + jnp.tanh(height))

    def control_values(self) -> Float[Array, " controls"]:
        """Physical values at the controls near the boundary, in the quantity's unit."""
        base = jnp.asarray(self.heights)[self.near]
        return jnp.exp(self._between(base + self.gain * self.shifts))

    def smooth_values(self) -> Float[Array, " controls"]:
        """The shifts of the boundary [1]."""
        return self.shifts

    def cell_values(self) -> Float[Array, " cells"]:
        """Values in the cells, in the quantity's unit."""
        height = self.cell_base + self.cell_weight @ self.shifts
        return jnp.exp(jnp.mean(self._between(height), axis=1))

    def face_values(self) -> Float[Array, " faces"]:
        """Values on the boundary faces, in the quantity's unit."""
        height = self.face_base + self.face_weight @ self.shifts
        return jnp.exp(jnp.mean(self._between(height), axis=1))


def _half_edge(mesh: Mesh) -> float:
    """Half the median edge of the surface [m]."""
    nodes, _ = surface_vertices(mesh)
    edges = mesh.nodes[nodes][surface_edges(mesh)]
    return 0.5 * float(np.median(np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)))


def two_material_values(
    boundary: Boundary, mesh: Mesh
) -> tuple[Float[np.ndarray, " cells"], Float[np.ndarray, " faces"]]:
    """Two materials in the cells and on the faces of any mesh [m], in the quantity's unit.

    No transition is needed where nothing is fitted: log phi is the mean of both by their shares of
    a cell, which the boundary cuts along a plane.
    """
    low, high = np.log(boundary.levels)
    height = _spline(boundary.points, boundary.heights)(mesh.nodes)
    cells, faces = (share_above(height[parts]) for parts in (mesh.cells[:, :4], mesh.faces[:, :3]))
    return np.exp(low + (high - low) * cells), np.exp(low + (high - low) * faces)


def two_groups(
    values: Float[np.ndarray, " controls"],
) -> tuple[Bool[np.ndarray, " controls"], float, float]:
    """Part numbers into two groups of least spread [1]: who is in the upper one, and both means.

    The best of all cuts of the sorted values, so that no start decides. Equal values are all in
    the lower group, and so is a single one.
    """
    order = np.sort(values)
    if len(order) < 2:
        return np.zeros(len(values), bool), float(values.mean()), float(values.mean())
    count = np.arange(1, len(order))
    sums = np.cumsum(order)
    left, right = sums[:-1] / count, (sums[-1] - sums[:-1]) / (len(order) - count)
    between = count * (len(order) - count) * (right - left) ** 2
    cut = int(np.argmax(between))
    upper = values > order[cut]
    return upper, float(left[cut]), float(right[cut])


def _calmed(
    values: Float[np.ndarray, " controls"], pairs: Int[np.ndarray, "pairs 2"]
) -> Float[np.ndarray, " controls"]:
    """Each number [1] one part itself, two parts its neighbours' mean: no control stands alone."""
    both = np.concatenate([pairs, pairs[:, ::-1]])
    size = len(values)
    count = np.bincount(both[:, 0], minlength=size)
    total = np.bincount(both[:, 0], values[both[:, 1]], minlength=size)
    mean = np.where(count > 0, total / np.maximum(count, 1), values)
    return (values + 2 * mean) / 3


def _heights(
    controls: ControlPoints, log: Float[np.ndarray, " controls"], upper: Bool[np.ndarray, " c"],
    middle: float,
) -> Float[np.ndarray, " controls"]:  # fmt: skip
    """Distance [m] of each control to the boundary, positive on the upper side."""
    first, second = controls.pairs[upper[controls.pairs[:, 0]] != upper[controls.pairs[:, 1]]].T
    share = np.clip((middle - log[first]) / (log[second] - log[first]), 0, 1)[:, None]
    crossing = controls.points[first] * (1 - share) + controls.points[second] * share
    apart = np.linalg.norm(controls.points[:, None] - crossing[None], axis=2).min(1)
    return np.where(upper, apart, -apart)


def _weights(
    points: Float[np.ndarray, "controls 3"],
    corners: Float[np.ndarray, "parts c 3"],
    inside: np.ndarray,
) -> Float[np.ndarray, "parts c controls"]:
    """Weights [1] of all controls at points `inside` cells or faces of given corners [m]."""
    place = np.einsum("qc,pcx->pqx", inside, corners)
    weights = _spline(points, np.eye(len(points)))(place.reshape(-1, 3))
    return weights.reshape(*place.shape[:2], -1)


def _spline(points: Float[np.ndarray, "controls 3"], values: np.ndarray) -> RBFInterpolator:
    """Biharmonic spline with a linear part through points [m]: a plane boundary stays a plane."""
    centred = points - points.mean(0)
    spread = np.linalg.svd(centred, compute_uv=False)
    flat = len(spread) < 3 or spread[-1] < 1e-6 * spread[0]
    return RBFInterpolator(points, values, kernel="linear", degree=0 if flat else 1)


def two_material_field(
    quantity: Quantity,
    mesh: Mesh,
    head: AbstractHead,
    controls: ControlPoints,
    values: Float[np.ndarray, " controls"],
) -> tuple[TwoMaterialField, Int[np.ndarray, "pairs 2"]] | None:
    """Two materials in place of a smooth field, and which of its controls are neighbours.

    Arguments:

    - `controls`: of the smooth field, with its `values` there, in the quantity's unit.

    The values are parted into two groups, whose means are the two first levels, and the boundary
    begins where the field passes midway between them; a control that differs from all around it
    makes no island, since the data rarely know a single one so well. The transition is half an
    edge of the surface wide on each side, what a mesh can show. None where there is one group, or
    where both share no boundary on the surface.
    """
    _, low, high = two_groups(np.log(values))
    middle = (low + high) / 2
    log = _calmed(np.clip(np.log(values), low, high), controls.pairs)
    upper = log > middle
    meet = upper[controls.pairs[:, 0]] != upper[controls.pairs[:, 1]]
    if high - low < 1e-6 or not meet.any():
        return None
    height = _heights(controls, log, upper, middle)
    step = np.linalg.norm(np.diff(controls.points[controls.pairs], axis=1)[:, 0], axis=1)
    spacing = float(np.median(step))
    near = np.flatnonzero(np.abs(height) < REACH * spacing)
    width = _half_edge(mesh)
    gain = SHIFT * spacing / width
    in_cells = _weights(controls.points, mesh.nodes[mesh.cells[:, :4]], CELL_POINTS)
    on_faces = _weights(controls.points, mesh.nodes[mesh.faces[:, :3]], FACE_POINTS)
    number = np.full(len(controls.vertex), -1)
    number[near] = np.arange(len(near))
    pairs = number[controls.pairs]
    field = TwoMaterialField(
        quantity,
        head,
        head.raw(jnp.exp(jnp.asarray([low, high]))),
        jnp.zeros(len(near)),
        jnp.asarray(in_cells @ height / width),
        jnp.asarray(in_cells[:, :, near] * gain),
        jnp.asarray(on_faces @ height / width),
        jnp.asarray(on_faces[:, :, near] * gain),
        jnp.asarray(gain),
        jnp.asarray(width),
        controls.points,
        height / width,
        near,
    )
    return field, pairs[(pairs >= 0).all(1)]
