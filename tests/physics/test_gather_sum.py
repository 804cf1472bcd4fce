"""Sums over groups against a dense map: forward, transposed, in batches, differentiated."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from thermo.physics._gather_sum import GatherSum, gather_sum, gather_to

RESULTS, SPARE = 5, 2
# Every result takes something.
TARGETS = st.lists(st.integers(0, RESULTS - 1), max_size=9).flatmap(
    lambda more: st.permutations([*range(RESULTS), *more])
)


def made(target: list[int]) -> tuple[GatherSum, np.ndarray]:
    matrix = np.zeros((RESULTS, len(target)))
    matrix[target, np.arange(len(target))] = 1.0
    return gather_to(np.array(target), RESULTS, SPARE), matrix


def with_zeros(values: np.ndarray) -> jax.Array:
    return jnp.concatenate([jnp.asarray(values), jnp.zeros(SPARE)])


@given(target=TARGETS, seed=st.integers(0, 99))
def test_the_map_and_its_transpose_are_those_of_the_matrix(target: list[int], seed: int) -> None:
    which, matrix = made(target)
    make = np.random.default_rng(seed)
    values, results = make.normal(size=len(target)), make.normal(size=RESULTS)
    np.testing.assert_allclose(gather_sum(which, with_zeros(values)), matrix @ values, atol=1e-14)
    back = gather_sum(which.transpose(), jnp.asarray(results))
    np.testing.assert_allclose(back[:-SPARE], matrix.T @ results, atol=1e-14)


def test_derivatives_are_the_map_and_its_transpose() -> None:
    which, matrix = made([3, 0, 0, 4, 1, 0, 3, 2])
    at, way = np.arange(8.0), np.linspace(-1.0, 1.0, 8)

    def mapped(values: jax.Array) -> jax.Array:
        return gather_sum(which, jnp.concatenate([values, jnp.zeros(SPARE)]))

    value, tangent = jax.jvp(mapped, (jnp.asarray(at),), (jnp.asarray(way),))
    np.testing.assert_allclose(value, matrix @ at)
    np.testing.assert_allclose(tangent, matrix @ way)
    cover = np.arange(5.0)
    (back,) = jax.vjp(mapped, jnp.asarray(at))[1](jnp.asarray(cover))
    np.testing.assert_allclose(back, matrix.T @ cover)
    many = np.stack([at, way, at * way])
    batch = jax.vmap(jax.vmap(mapped))(jnp.asarray(many)[None])
    np.testing.assert_allclose(batch[0], (matrix @ many.T).T, atol=1e-14)
