"""Sums over groups against a dense map: forward, transposed, in batches, differentiated."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from thermo.physics._gather_sum import GatherSum, gather_sum, gather_to

TARGETS = st.lists(st.integers(-1, 4), min_size=1, max_size=12)
RESULTS = 5


def dense(target: np.ndarray) -> np.ndarray:
    matrix = np.zeros((RESULTS, len(target)))
    for value, result in enumerate(target):
        if result >= 0:
            matrix[result, value] = 1.0
    return matrix


def made(target: list[int]) -> tuple[GatherSum, np.ndarray]:
    return gather_to(np.array(target), RESULTS), dense(np.array(target))


@given(target=TARGETS, seed=st.integers(0, 99))
def test_the_map_and_its_transpose_are_those_of_the_matrix(target: list[int], seed: int) -> None:
    which, matrix = made(target)
    if which.groups.shape[0] == 0:
        return
    make = np.random.default_rng(seed)
    values, results = make.normal(size=len(target)), make.normal(size=RESULTS)
    np.testing.assert_allclose(gather_sum(which, jnp.asarray(values)), matrix @ values, atol=1e-14)
    back = gather_sum(which.transpose(), jnp.asarray(results))
    np.testing.assert_allclose(back, matrix.T @ results, atol=1e-14)


def test_derivatives_are_the_map_and_its_transpose() -> None:
    which, matrix = made([3, 0, 0, 4, 1, 0, 3, -1])
    at, way = jnp.arange(8.0), jnp.linspace(-1.0, 1.0, 8)
    value, tangent = jax.jvp(lambda v: gather_sum(which, v), (at,), (way,))
    np.testing.assert_allclose(value, matrix @ at)
    np.testing.assert_allclose(tangent, matrix @ way)
    cover = jnp.arange(5.0)
    (back,) = jax.vjp(lambda v: gather_sum(which, v), at)[1](cover)
    np.testing.assert_allclose(back, matrix.T @ cover)
    many = jnp.stack([at, way, at * way])
    batch = jax.vmap(jax.vmap(lambda v: gather_sum(which, v)))(many[None])
    np.testing.assert_allclose(batch[0], (matrix @ many.T).T, atol=1e-14)
