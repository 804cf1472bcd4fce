"""Products node by node: as plain ones, in every derivative and with every batch."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.physics._diagonal_product import diagonal_product

MAKE = np.random.default_rng(0)
FACTOR, VECTOR, CHANGE, TURN = (jnp.asarray(MAKE.normal(size=7)) for _ in range(4))
MANY = jnp.asarray(MAKE.normal(size=(3, 7)))


def test_values_and_derivatives_are_those_of_a_plain_product() -> None:
    value, tangent = jax.jvp(diagonal_product, (FACTOR, VECTOR), (CHANGE, TURN))
    np.testing.assert_allclose(value, FACTOR * VECTOR)
    np.testing.assert_allclose(tangent, CHANGE * VECTOR + FACTOR * TURN)
    back = jax.vjp(diagonal_product, FACTOR, VECTOR)[1](CHANGE)
    np.testing.assert_allclose(back[0], CHANGE * VECTOR)
    np.testing.assert_allclose(back[1], CHANGE * FACTOR)


@pytest.mark.parametrize("axes", [(0, None), (None, 0), (0, 0)])
def test_batches_are_single_products(axes: tuple[int | None, int | None]) -> None:
    pair = [MANY if axis == 0 else VECTOR for axis in axes]
    found = jax.vmap(diagonal_product, in_axes=axes)(*pair)
    np.testing.assert_allclose(found, pair[0] * pair[1])
    turned = jax.vmap(diagonal_product, in_axes=axes, out_axes=-1)(*pair)
    np.testing.assert_allclose(turned, (pair[0] * pair[1]).T)


def test_a_batch_of_batches() -> None:
    outer = jnp.asarray(MAKE.normal(size=(2, 7)))
    inner = jax.vmap(diagonal_product, in_axes=(0, None))
    crossed = jax.vmap(inner, in_axes=(None, 0))(MANY, outer)
    np.testing.assert_allclose(crossed, MANY[None] * outer[:, None])
    both = jax.vmap(inner, in_axes=(0, None))(jnp.stack([MANY, 2 * MANY]), VECTOR)
    np.testing.assert_allclose(both, jnp.stack([MANY, 2 * MANY]) * VECTOR)


def test_what_served_a_batch_answers_for_all_of_it() -> None:
    def total(factor: jax.Array) -> jax.Array:
        return jnp.sum(jax.vmap(lambda v: diagonal_product(factor, v))(MANY) ** 2)

    expected = jax.grad(lambda factor: jnp.sum((factor * MANY) ** 2))(FACTOR)
    np.testing.assert_allclose(jax.grad(total)(FACTOR), expected)
