"""Products by edges: against the dense matrix, forward, transposed and in batches."""

from __future__ import annotations

from collections.abc import Iterator

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo._remembered import forget
from thermo.mesh import ball_mesh, promote
from thermo.physics import Discretisation, _pattern, discretise
from thermo.physics._edge_product import difference_product, edge_product
from thermo.physics._pattern import expand

RNG = np.random.default_rng(5)


@pytest.fixture(scope="module")
def space() -> Discretisation:
    return discretise(promote(ball_mesh(0.02, 2)))


def draw(space: Discretisation) -> tuple[jax.Array, jax.Array, jax.Array]:
    nodes, edges = len(space.mesh.nodes), len(space.pattern.first)
    return tuple(jnp.asarray(RNG.standard_normal(n)) for n in (nodes, edges, nodes))  # type: ignore[return-value]


def dense(space: Discretisation, diagonal: np.ndarray, edges: np.ndarray) -> np.ndarray:
    matrix = np.diag(np.asarray(diagonal))
    matrix[space.pattern.first, space.pattern.second] = edges
    matrix[space.pattern.second, space.pattern.first] = edges
    return matrix


def test_products_are_those_of_the_dense_matrix(space: Discretisation) -> None:
    diagonal, edges, vector = draw(space)
    matrix = dense(space, diagonal, edges)
    product = edge_product(space.pattern, diagonal, edges, vector)
    np.testing.assert_allclose(product, matrix @ vector, rtol=0, atol=1e-12)
    off = dense(space, np.zeros_like(diagonal), edges)
    difference = difference_product(space.pattern, edges, vector)
    np.testing.assert_allclose(difference, off @ vector - off.sum(1) * vector, rtol=0, atol=1e-12)
    # The same from the padded rows.
    rows = expand(space.pattern, edges)
    by_rows = edge_product(space.pattern, diagonal, edges, vector, rows)
    np.testing.assert_allclose(by_rows, product, rtol=0, atol=1e-13)
    by_rows = difference_product(space.pattern, edges, vector, rows)
    np.testing.assert_allclose(by_rows, difference, rtol=0, atol=1e-13)


@pytest.fixture
def afresh() -> Iterator[None]:
    """Patterns are made anew, and those that a test made otherwise are not kept."""
    forget()
    yield
    forget()


@pytest.mark.usefixtures("afresh")
@pytest.mark.parametrize(("few", "longest"), [(0, _pattern.RUN), (10**6, _pattern.SHORT_RUN)])
def test_rows_are_cut_in_shorter_runs_where_nodes_are_few(
    monkeypatch: pytest.MonkeyPatch, few: int, longest: int
) -> None:
    monkeypatch.setattr(_pattern, "FEW_NODES", few)
    space = discretise(promote(ball_mesh(0.02, 3)))
    runs = [block.shape[1] for block in space.pattern.columns]
    assert longest / 2 < max(runs) <= longest
    diagonal, edges, vector = draw(space)
    product = edge_product(space.pattern, diagonal, edges, vector)
    wanted = dense(space, np.asarray(diagonal), np.asarray(edges)) @ np.asarray(vector)
    np.testing.assert_allclose(product, wanted, rtol=0, atol=1e-12)


@pytest.mark.usefixtures("afresh")
def test_a_dear_gather_makes_fewer_of_them_and_more_padding(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mesh = promote(ball_mesh(0.02, 6))
    there = discretise(mesh).pattern
    monkeypatch.setattr(_pattern, "GATHER_COST", 2 * _pattern.GATHER_COST)
    forget()
    here = discretise(mesh).pattern
    gathers, entries = zip(
        *((sum(b.shape[1] for b in one.columns), sum(b.size for b in one.columns))
          for one in (here, there)), strict=True,
    )  # fmt: skip
    assert gathers[0] < gathers[1] and entries[0] > entries[1]


@pytest.mark.parametrize("padded", [False, True])
@pytest.mark.parametrize("differences", [False, True])
def test_transposes_and_tangents(space: Discretisation, differences: bool, padded: bool) -> None:
    diagonal, edges, vector = draw(space)
    way = (
        jnp.asarray(RNG.standard_normal(len(edges))),
        jnp.asarray(RNG.standard_normal(len(vector))),
    )

    def product(edges: jax.Array, vector: jax.Array) -> jax.Array:
        rows = expand(space.pattern, jax.lax.stop_gradient(edges)) if padded else None
        if differences:
            return difference_product(space.pattern, edges, vector, rows)
        return edge_product(space.pattern, diagonal, edges, vector, rows)

    value, tangent = jax.jvp(product, (edges, vector), way)
    # Bilinear: the difference quotient is exact up to the product of both changes.
    moved = product(edges + way[0], vector + way[1]) - value
    both = product(way[0], way[1]) - (0 if differences else diagonal * way[1])
    np.testing.assert_allclose(tangent, moved - both, rtol=0, atol=1e-11)
    cover = jnp.asarray(RNG.standard_normal(len(vector)))
    _, pull = jax.vjp(product, edges, vector)
    back = pull(cover)
    assert float(cover @ tangent) == pytest.approx(
        float(back[0] @ way[0] + back[1] @ way[1]), rel=1e-11
    )


@pytest.mark.parametrize("padded", [False, True])
def test_batches_equal_single_products(space: Discretisation, padded: bool) -> None:
    _, edges, vector = draw(space)
    many_edges = jnp.asarray(RNG.standard_normal((2, 3, len(edges))))
    many_vectors = jnp.asarray(RNG.standard_normal((3, len(vector))))

    def product(edges: jax.Array, vector: jax.Array) -> jax.Array:
        rows = expand(space.pattern, edges) if padded else None
        return difference_product(space.pattern, edges, vector, rows)

    over_both = jax.vmap(product)(many_edges[0], many_vectors)
    over_edges = jax.vmap(product, in_axes=(0, None))(many_edges[0], vector)
    nested = jax.vmap(jax.vmap(product))(many_edges, jnp.stack([many_vectors, many_vectors]))
    outer = jax.vmap(jax.vmap(product, in_axes=(None, 0)), in_axes=(0, None))(
        many_edges[:, 0], many_vectors
    )
    for place in range(3):
        one = product(many_edges[0, place], many_vectors[place])
        np.testing.assert_allclose(over_both[place], one, atol=1e-12)
        np.testing.assert_allclose(nested[0, place], one, atol=1e-12)
        alone = product(many_edges[0, place], vector)
        np.testing.assert_allclose(over_edges[place], alone, atol=1e-12)
        np.testing.assert_allclose(
            outer[1, place], product(many_edges[1, 0], many_vectors[place]), atol=1e-12
        )


def test_gradients_of_a_batch_are_sums(space: Discretisation) -> None:
    _, edges, vector = draw(space)
    many = jnp.asarray(RNG.standard_normal((4, len(vector))))

    def total(edges: jax.Array, vector: jax.Array) -> jax.Array:
        each = jax.vmap(lambda v: difference_product(space.pattern, edges, v * vector))(many)
        return jnp.sum(each**2)

    got = jax.grad(total, argnums=(0, 1))(edges, vector)
    singles = [
        jax.grad(
            lambda e, v, row=row: jnp.sum(difference_product(space.pattern, e, row * v) ** 2),
            argnums=(0, 1),
        )(edges, vector)
        for row in many
    ]
    for number in (0, 1):
        expected = np.sum([single[number] for single in singles], axis=0)
        np.testing.assert_allclose(got[number], expected, rtol=1e-10, atol=1e-9)


def test_constants_give_exactly_nothing(space: Discretisation) -> None:
    _, edges, vector = draw(space)
    rest = difference_product(space.pattern, edges, jnp.full_like(vector, 295.15))
    assert not np.any(rest)
