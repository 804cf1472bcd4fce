"""Mass, stiffness and surface matrices against scikit-fem, and what they must keep."""

from __future__ import annotations

from functools import cache

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import skfem
from scipy.spatial import cKDTree
from skfem.helpers import dot, grad, mul

from thermo.mesh import box_mesh, mesh_from_cells, promote
from thermo.physics import Model, StepMatrix, assemble, discretise, heat_rate, step_matrix
from thermo.physics.effects import Convection, PrescribedFlux, Schedule, VolumetricSource

CAPACITY_AT = 1.5e6


@cache
def bent(order: int):
    """A box of irregular cells, discretised."""
    plain = box_mesh((0.1, 0.08, 0.06), (3, 2, 2))
    x, y, z = plain.nodes.T
    moved = np.stack([x + 0.1 * y - 2 * z**2, y + 0.2 * x * z / 0.1, z + 0.05 * np.sin(30 * x)], 1)
    mesh = mesh_from_cells(moved, plain.cells)
    return discretise(mesh if order == 1 else promote(mesh))


@cache
def reference(order: int):
    """The same mesh in scikit-fem: basis, boundary basis, cell and facet data, numbering."""
    mesh = bent(order).mesh
    corners = np.unique(mesh.cells[:, :4])
    number = np.full(len(mesh.nodes), -1)
    number[corners] = np.arange(len(corners))
    other = skfem.MeshTet(
        np.ascontiguousarray(mesh.nodes[corners].T),
        np.ascontiguousarray(number[mesh.cells[:, :4]].T.astype(np.int64)),
    )
    element = skfem.ElementTetP1() if order == 1 else skfem.ElementTetP2()
    basis = skfem.Basis(other, element, intorder=2 * order)
    rim = skfem.FacetBasis(other, element, intorder=2 * order)
    away, ours = cKDTree(mesh.nodes).query(basis.doflocs.T)
    assert away.max() < 1e-12
    return basis, rim, ours


def random(seed: int, count: int, low: float, high: float) -> np.ndarray:
    return np.random.default_rng(seed).uniform(low, high, count)


def cell_order(order: int) -> np.ndarray:
    """For each cell of scikit-fem the number of ours."""
    mesh, (basis, _, ours) = bent(order).mesh, reference(order)
    key = {tuple(sorted(cell[:4])): i for i, cell in enumerate(mesh.cells.tolist())}
    corners = ours[basis.element_dofs[:4]].T.tolist()
    return np.array([key[tuple(sorted(cell))] for cell in corners])


def dense(order: int, matrix) -> np.ndarray:
    """A matrix of scikit-fem in our numbering."""
    _, _, ours = reference(order)
    out = np.empty(matrix.shape)
    out[np.ix_(ours, ours)] = matrix.toarray()
    return out


def close(ours: np.ndarray, theirs: np.ndarray) -> None:
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())


def model(order: int, conductivity: np.ndarray, capacity: np.ndarray, surface=()) -> Model:
    return Model(bent(order), jnp.asarray(conductivity), jnp.asarray(capacity), surface)


def matrix(order: int, weight: float, conductivity, capacity, surface=()) -> np.ndarray:
    made = model(order, conductivity, capacity, surface)
    return np.asarray(dense_matrix(made, jnp.asarray(weight)))


@eqx.filter_jit
def dense_matrix(model: Model, weight: jax.Array) -> jax.Array:
    zero = jnp.zeros(len(model.space.mesh.nodes))
    return step_matrix(assemble(model), zero, weight).as_matrix()


@pytest.mark.parametrize("order", [1, 2])
def test_mass_matrix(order: int) -> None:
    cells = len(bent(order).mesh.cells)
    capacity = random(0, cells, 1e6, 4e6)
    ours = matrix(order, 0.0, np.ones(cells), capacity)
    basis, _, _ = reference(order)
    spread = basis.with_element(skfem.ElementTetP0()).zeros()
    spread[:] = capacity[cell_order(order)]
    content = basis.with_element(skfem.ElementTetP0()).interpolate(spread)
    theirs = skfem.BilinearForm(lambda u, v, w: w["c"] * u * v).assemble(basis, c=content)
    close(ours, dense(order, theirs))
    total = (capacity * bent(order).volume).sum()
    np.testing.assert_allclose(ours.sum(), total, rtol=1e-13)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("tensor", [False, True])
def test_stiffness_matrix(order: int, tensor: bool) -> None:
    cells = len(bent(order).mesh.cells)
    conductivity = random(1, cells, 0.1, 5.0)
    if tensor:
        root = np.random.default_rng(2).normal(size=(cells, 3, 3))
        conductivity = root @ np.swapaxes(root, 1, 2) + 0.1 * np.eye(3)
    with_heat, without = (
        matrix(order, weight, conductivity, np.ones(cells)) for weight in (1.0, 0.0)
    )
    basis, _, _ = reference(order)
    flat = conductivity[cell_order(order)]
    if tensor:
        field = np.moveaxis(flat, 0, -1)[..., None] * np.ones(basis.X.shape[-1])
        form = skfem.BilinearForm(lambda u, v, w: dot(mul(field, grad(u)), grad(v)))
    else:
        field = flat[:, None]
        form = skfem.BilinearForm(lambda u, v, w: field * dot(grad(u), grad(v)))
    close(with_heat - without, dense(order, form.assemble(basis)))


@pytest.mark.parametrize("order", [1, 2])
def test_surface_matrix_and_load(order: int) -> None:
    space = bent(order)
    cells, faces = len(space.mesh.cells), len(space.mesh.faces)
    centre = space.mesh.nodes[space.mesh.faces[:, :3]].mean(1)
    coefficient = random(3, faces, 1.0, 20.0)
    surface = (Convection(jnp.asarray(coefficient), 0.0),)
    tiny = np.full(cells, 1e-9)
    ours = matrix(order, 1.0, tiny, tiny, surface) - matrix(order, 1.0, tiny, tiny)
    basis, rim, numbers = reference(order)
    middle = rim.mesh.p[:, rim.mesh.facets[:, rim.find]].mean(1).T
    away, at = cKDTree(centre).query(middle)
    assert away.max() < 1e-12
    field = coefficient[at][:, None]
    theirs = skfem.BilinearForm(lambda u, v, w: field * u * v).assemble(rim)
    close(ours, dense(order, theirs))
    load = heat_rate(
        assemble(model(order, tiny, tiny, (PrescribedFlux(jnp.asarray(coefficient)),))),
        jnp.zeros(len(space.mesh.nodes)),
        0.0,
    )
    expected = np.empty(len(space.mesh.nodes))
    expected[numbers] = skfem.LinearForm(lambda v, w: field * v).assemble(rim)
    close(np.asarray(load), expected)


@pytest.mark.parametrize("order", [1, 2])
def test_volume_load(order: int) -> None:
    space = bent(order)
    cells = len(space.mesh.cells)
    density = random(4, cells, 1.0, 20.0)
    source = VolumetricSource(jnp.asarray(density), Schedule(1.0))
    balance = assemble(Model(space, jnp.ones(cells), jnp.ones(cells), volume=(source,)))
    load = heat_rate(balance, jnp.zeros(len(space.mesh.nodes)), 0.5)
    basis, _, numbers = reference(order)
    field = density[cell_order(order)][:, None]
    expected = np.empty(len(space.mesh.nodes))
    expected[numbers] = skfem.LinearForm(lambda v, w: field * v).assemble(basis)
    close(np.asarray(load), expected)
    assert not np.asarray(heat_rate(balance, jnp.zeros(len(space.mesh.nodes)), 1.5)).any()


@pytest.mark.parametrize("order", [1, 2])
def test_constants_conduct_nothing_to_the_last_bit(order: int) -> None:
    space = bent(order)
    cells = len(space.mesh.cells)
    balance = assemble(model(order, random(5, cells, 0.1, 5.0), np.ones(cells)))
    rate = heat_rate(balance, jnp.full(len(space.mesh.nodes), 293.15), 0.0)
    assert not np.asarray(rate).any()


@pytest.mark.parametrize("order", [1, 2])
def test_stiffness_is_exact_for_linear_temperatures(order: int) -> None:
    """The heat through the surface of a body with T = g . x is k g . n, so the inside rests."""
    space = bent(order)
    cells = len(space.mesh.cells)
    slope = np.array([3.0, -2.0, 5.0])
    balance = assemble(model(order, np.full(cells, 2.5), np.ones(cells)))
    rate = np.asarray(heat_rate(balance, jnp.asarray(space.mesh.nodes @ slope), 0.0))
    inside = np.setdiff1d(np.arange(len(space.mesh.nodes)), space.mesh.faces)
    assert len(inside) > 0
    assert np.abs(rate[inside]).max() < 1e-13 * np.abs(rate).max()
    flow = -(space.mesh.nodes[:, 0] @ rate)
    np.testing.assert_allclose(flow, 2.5 * slope[0] * space.mesh.volume(), rtol=1e-12)


def test_operator_forms_agree() -> None:
    space = bent(2)
    cells, nodes = len(space.mesh.cells), len(space.mesh.nodes)
    coefficient = jnp.asarray(random(6, len(space.mesh.faces), 1.0, 20.0))
    surface = (Convection(coefficient, 0.0),)
    balance = assemble(model(2, random(7, cells, 0.1, 5.0), random(8, cells, 1e6, 4e6), surface))
    operator = step_matrix(balance, jnp.zeros(nodes), 3.0)
    assert isinstance(operator, StepMatrix)
    whole = np.asarray(operator.as_matrix())
    np.testing.assert_array_equal(whole, whole.T)
    vector = random(9, nodes, -1.0, 1.0)
    expected = whole @ vector
    tolerance = 1e-13 * np.abs(expected).max()
    np.testing.assert_allclose(operator.mv(jnp.asarray(vector)), expected, atol=tolerance)
    several = operator.mv(jnp.stack([jnp.asarray(vector), jnp.ones(nodes)], axis=1))
    np.testing.assert_allclose(several[:, 0], expected, atol=tolerance)
    np.testing.assert_allclose(several[:, 1], whole.sum(1), atol=tolerance)
