"""Features on grids."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.reconstruct._grid_encoding import GridEncoding


def filled(cells: tuple[int, ...]) -> GridEncoding:
    """Whose corners hold a function that is linear along each axis: trilinear, so exact."""
    encoding = GridEncoding(cells, 2, key=jax.random.key(0))
    tables = []
    for count in cells:
        axis = np.linspace(-1.0, 1.0, count + 1)
        x, y, z = (part.ravel() for part in np.meshgrid(axis, axis, axis, indexing="ij"))
        tables.append(jnp.asarray(np.stack([1 + 2 * x - y + 3 * z, x * y * z], axis=1)))
    return eqx.tree_at(lambda one: one.tables, encoding, tuple(tables))


def test_trilinear_functions_come_out_exactly() -> None:
    places = jax.random.uniform(jax.random.key(1), (200, 3), minval=-1.0, maxval=1.0)
    places = jnp.concatenate([places, jnp.asarray([[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0]])])
    x, y, z = np.asarray(places).T
    got = np.asarray(filled((1, 5))(places, jnp.asarray(2.0)))
    line, product = 1 + 2 * x - y + 3 * z, x * y * z
    # The product is trilinear over the whole cube, of which one cell is all.
    assert np.allclose(got[:, :2], np.stack([line, product], axis=1), atol=1e-12)
    assert np.allclose(got[:, 2], line, atol=1e-12)
    # Over a cell of a finer grid it is trilinear as well.
    assert np.allclose(got[:, 3], product, atol=1e-12)


def test_outside_the_cube_the_edge_counts() -> None:
    encoding = filled((4,))
    there, edge = (jnp.asarray([[x, 0.3, -2.0]]) for x in (5.0, 1.0))
    assert np.allclose(encoding(there, jnp.asarray(1.0)), encoding(edge, jnp.asarray(1.0)))


@pytest.mark.parametrize(
    ("open_levels", "shares"), [(1.0, (1, 0)), (1.25, (1, 0.25)), (9.0, (1, 1))]
)
def test_levels_open_one_after_another(open_levels: float, shares: tuple[float, float]) -> None:
    encoding = filled((2, 4))
    places = jnp.asarray([[0.1, 0.2, 0.3]])
    whole = np.asarray(encoding(places, jnp.asarray(2.0)))
    part = np.asarray(encoding(places, jnp.asarray(open_levels)))
    assert np.allclose(part, whole * np.repeat(shares, 2))
