"""Everything of the heat equation that the mesh alone decides, made once for each mesh."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from thermo._remembered import remembered
from thermo.mesh import Mesh, cell_volumes, face_areas
from thermo.physics._coarse_spaces import CoarseSpaces, coarse_spaces
from thermo.physics._gather_sum import GatherSum, gather_sum, gather_to
from thermo.physics._pattern import (
    Pattern,
    cell_pairs,
    find_pairs,
    make_pattern,
    of_surface,
    row_lengths,
)
from thermo.physics._quadrature import triangle_rule
from thermo.physics._shape import face_shape, reference_mass, reference_stiffness


@final
class Discretisation(eqx.Module):
    """Geometry of the weak form on one mesh, ready for any material and boundary.

    The nodes of `mesh` are renumbered so that products are fast: use this mesh, not the one that
    went in, to read nodal values.

    - `gradient`: V g_a . g_b of the barycentric gradients, (cells, 4, 3) holding V^(1/2) g [m^1/2].
    - `volume`: (cells,) [m3].
    - `surface`: the pattern of matrices on the nodes of the surface alone.
    - `cell_edge`: the edge of each node pair of a cell.
    - `to_nodes`: from the corners of all faces, corner by corner, to the nodes of the surface.
    - `to_edges`: from the node pairs of all faces, pair by pair, to the edges of the surface.
    - `face_shape`: (points, corners) [1]; `face_weight`: (faces, points) [m2].
    - `face_point`: quadrature points on the faces, (faces, points, 3) [m].
    - `coarse`: coarser spaces for the solver, or None where they do not pay.
    """

    mesh: Mesh
    pattern: Pattern
    surface: Pattern
    gradient: Float[Array | np.ndarray, "cells 4 3"]
    volume: Float[Array | np.ndarray, " cells"]
    cell_edge: Int[Array | np.ndarray, "cells pairs"]
    to_nodes: GatherSum
    to_edges: GatherSum
    face_shape: Float[Array | np.ndarray, "points corners"]
    face_weight: Float[Array | np.ndarray, "faces points"]
    face_point: Float[Array | np.ndarray, "faces points 3"]
    coarse: CoarseSpaces | None

    @property
    def order(self) -> int:
        """Polynomial order [1] of the elements."""
        return self.mesh.order


def _renumber(mesh: Mesh) -> Mesh:
    count = len(mesh.nodes)
    pairs, _ = cell_pairs(mesh.cells, count)
    both = np.concatenate([pairs, pairs[:, ::-1]])
    graph = csr_matrix((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(count, count))
    place = np.empty(count, np.int64)
    place[reverse_cuthill_mckee(graph, symmetric_mode=True)] = np.arange(count)
    surface = np.zeros(count, bool)
    surface[mesh.faces] = True
    old = np.lexsort((place, -row_lengths(pairs, count), surface))
    new = np.empty(count, np.int32)
    new[old] = np.arange(count, dtype=np.int32)
    return Mesh(
        nodes=mesh.nodes[old],
        cells=new[mesh.cells],
        faces=new[mesh.faces],
        owners=mesh.owners,
        normals=mesh.normals,
        regions=mesh.regions,
    )


def _barycentric_gradients(mesh: Mesh) -> Float[np.ndarray, "cells 4 3"]:
    corner = mesh.nodes[mesh.cells[:, :4]]
    inverse = np.linalg.inv(corner[:, 1:] - corner[:, :1])  # (cells, xyz, 3)
    rest = np.swapaxes(inverse, 1, 2)
    return np.concatenate([-rest.sum(1, keepdims=True), rest], 1)


def discretise(mesh: Mesh, reach: float = 0.0) -> Discretisation:
    """Prepare a mesh [m] for simulation.

    Arguments:

    - `mesh`: a validated TET4 or TET10 mesh, nodes (nodes, 3) [m].
    - `reach`: diffusivity times the weight of a step in its matrix [m2], the square of how far heat
      goes in it. Where that is many cells, coarser spaces of the mesh help the solver along.
    """
    space = _prepared(mesh)
    return replace(space, coarse=coarse_spaces(space.mesh, np.asarray(space.gradient), reach))


@remembered(4)
def _prepared(mesh: Mesh) -> Discretisation:
    """A mesh [m] without coarser spaces: a search simulates on a few meshes over and over."""
    mesh = _renumber(mesh)
    count = len(mesh.nodes)
    pairs, cell_edge = cell_pairs(mesh.cells, count)
    face_edge = find_pairs(pairs, mesh.faces, count)
    surface_edges, edge_number = np.unique(face_edge, return_inverse=True)
    surface = np.zeros(count, bool)
    surface[mesh.faces] = True
    pattern = make_pattern(pairs, surface_edges, surface)
    corners = mesh.faces.T.ravel() - pattern.inner
    of_pair = edge_number.reshape(face_edge.shape).T.ravel()
    volume = cell_volumes(mesh)
    points, weights = triangle_rule(mesh.order)
    gradient = _barycentric_gradients(mesh) * np.sqrt(volume)[:, None, None]
    return Discretisation(
        mesh=mesh,
        pattern=pattern,
        surface=of_surface(pattern),
        gradient=gradient,
        volume=volume,
        cell_edge=cell_edge,
        to_nodes=gather_to(corners, count - pattern.inner, len(mesh.faces)),
        to_edges=gather_to(of_pair, len(surface_edges), len(mesh.faces)),
        face_shape=face_shape(points, mesh.order),
        face_weight=face_areas(mesh)[:, None] * weights,
        face_point=np.einsum("qa,fax->fqx", points, mesh.nodes[mesh.faces[:, :3]]),
        coarse=None,
    )


def stiffness_edges(
    space: Discretisation,
    conductivity: Float[Array, " cells"] | Float[Array, "cells 3 3"],
) -> Float[Array, " edges"]:
    """Off-diagonal entries [W/K] of K, K_ij = integral of grad N_i . k grad N_j.

    Arguments:

    - `conductivity`: one value a cell, (cells,), or a symmetric tensor, (cells, 3, 3) [W/m/K].
    """
    scalar = conductivity.ndim == 1
    flow = space.gradient
    if not scalar:
        flow = jnp.einsum("cax,cxy->cay", space.gradient, conductivity)
    products = jnp.einsum("cax,cbx->cab", flow, space.gradient)
    upper = np.triu_indices(space.mesh.cells.shape[1], 1)
    reference = jnp.asarray(reference_stiffness(space.order)[upper])
    terms = jnp.einsum("cab,pab->cp", products, reference)
    # Last, so that tangents of the conductivity meet nothing but this product.
    terms = conductivity[:, None] * terms if scalar else terms
    return jnp.zeros(space.pattern.first.shape[0]).at[space.cell_edge].add(terms)


def diagonal_of(space: Discretisation, edges: Float[Array, " edges"]) -> Float[Array, " nodes"]:
    """Diagonal [W/K] of a matrix whose rows sum to zero."""
    ends = jnp.concatenate([space.pattern.first, space.pattern.second])
    return jnp.zeros(len(space.mesh.nodes)).at[ends].add(-jnp.concatenate([edges, edges]))


def mass(
    space: Discretisation, capacity: Float[Array, " cells"]
) -> tuple[Float[Array, " nodes"], Float[Array, " edges"]]:
    """Consistent mass matrix [J/K] as diagonal and edges, M_ij = integral of rho c N_i N_j.

    Arguments:

    - `capacity`: volumetric heat capacity of each cell, (cells,) [J/m3/K].
    """
    reference = reference_mass(space.order)
    upper = np.triu_indices(len(reference), 1)
    content = capacity * space.volume
    diagonal = jnp.zeros(len(space.mesh.nodes))
    diagonal = diagonal.at[space.mesh.cells].add(content[:, None] * np.diag(reference))
    edges = jnp.zeros(space.pattern.first.shape[0])
    return diagonal, edges.at[space.cell_edge].add(content[:, None] * reference[upper])


def surface_mass(
    space: Discretisation, weight: Float[Array, "faces points"]
) -> tuple[Float[Array, " surface_nodes"], Float[Array, " surface_edges"]]:
    """Surface matrix [W/K], integral of w N_i N_j over the boundary.

    Its diagonal on the nodes of the surface, which come last, and its values on the pattern's
    edges of the surface.

    Arguments:

    - `weight`: coefficient at the face points, (faces, points) [W/m2/K].
    """
    shape = space.face_shape
    scaled = (weight * space.face_weight).T
    a, b = np.triu_indices(shape.shape[1], 1)
    return (
        gather_sum(space.to_nodes, _sums(scaled, shape**2)),
        gather_sum(space.to_edges, _sums(scaled, shape[:, a] * shape[:, b])),
    )


def _sums(
    values: Float[Array, "points faces"], weight: Float[Array | np.ndarray, "points sums"]
) -> Float[Array, " all"]:
    """Weighted sums over the points of each face, one after the other, and a row of zeros.

    Written out: as a product of such thin matrices, or with the sums put together afterwards,
    this would be slow.
    """
    wide = jnp.concatenate([weight, jnp.zeros((len(weight), 1))], axis=1)[:, :, None]
    total = wide[0] * values[0]
    for factor, row in zip(wide[1:], values[1:], strict=True):
        total = total + factor * row
    return total.ravel()


def surface_load(
    space: Discretisation, flux: Float[Array, "faces points"]
) -> Float[Array, " nodes"]:
    """Nodal heat rate [W] of a flux into the body given at the face points [W/m2]."""
    scaled = (flux * space.face_weight).T
    outer = gather_sum(space.to_nodes, _sums(scaled, jnp.asarray(space.face_shape)))
    return jnp.pad(outer, (space.pattern.inner, 0))


def volume_load(space: Discretisation, density: Float[Array, " cells"]) -> Float[Array, " nodes"]:
    """Nodal heat rate [W] of a power density given for each cell, (cells,) [W/m3]."""
    share = jnp.asarray(reference_mass(space.order).sum(1))
    terms = (density * space.volume)[:, None] * share
    return jnp.zeros(len(space.mesh.nodes)).at[space.mesh.cells].add(terms)


def on_faces(
    space: Discretisation, temperature: Float[Array, " nodes"]
) -> Float[Array, "faces points"]:
    """Temperature [K] at the quadrature points of the boundary faces."""
    shape = space.face_shape
    outer = temperature[space.pattern.inner :]
    corners = gather_sum(space.to_nodes.transpose(), outer)
    corners = corners.reshape(shape.shape[1] + 1, -1)[:-1]
    # From differences, so that a constant comes back to the last bit.
    rise, weight = corners[1:] - corners[0], jnp.asarray(shape)[:, 1:, None]
    total = corners[0] + weight[:, 0] * rise[0]
    for place in range(1, len(rise)):
        total = total + weight[:, place] * rise[place]
    return total.T
