"""The learned distance: a ball at first, and its gradient."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from thermo.reconstruct._distance_network import FIRST_RADIUS, DistanceNetwork, with_gradient

LEVELS = jnp.asarray(2.0)
# Compiled whole: operation by operation each would be a program of its own.
sloped = eqx.filter_jit(with_gradient)
heard = eqx.filter_jit(lambda network, places: network(places, LEVELS)[0])
PLACES = jax.random.uniform(jax.random.key(5), (300, 3), minval=-1.0, maxval=1.0)


def fresh() -> DistanceNetwork:
    return DistanceNetwork((4, 9), 2, 16, 3, key=jax.random.key(0))


def learned() -> DistanceNetwork:
    """One with weights all over, in double precision."""
    arrays, rest = eqx.partition(fresh(), eqx.is_array)
    leaves, shape = jax.tree.flatten(arrays)
    keys = jax.random.split(jax.random.key(9), len(leaves))
    noisy = [0.3 * jax.random.normal(k, one.shape) for k, one in zip(keys, leaves, strict=True)]
    return eqx.combine(jax.tree.unflatten(shape, noisy), rest)


def test_it_begins_as_an_exact_distance_from_a_ball() -> None:
    places = np.asarray(PLACES).copy()
    places[0] = 0.0
    found = sloped(fresh(), jnp.asarray(places), LEVELS)
    distance, told, gradient = (np.asarray(one) for one in found)
    radius = np.linalg.norm(places, axis=1)
    # In the very middle the root is rounded.
    assert np.abs(distance - (radius - FIRST_RADIUS))[1:].max() < 1e-4
    assert np.abs(told).max() == 0
    away = radius > 0.1
    assert np.abs(np.linalg.norm(gradient, axis=1) - 1)[away].max() < 1e-4
    assert distance[0] < 0


def test_its_gradient_is_that_of_finite_differences() -> None:
    network, size = learned(), 1e-6
    gradient = np.asarray(sloped(network, PLACES, LEVELS)[2])
    for axis in range(3):
        step = size * np.eye(3)[axis]
        places = [jnp.asarray(np.asarray(PLACES) + way * step) for way in (1, -1)]
        ahead, behind = (np.asarray(heard(network, one)) for one in places)
        off = np.abs((ahead - behind) / (2 * size) - gradient[:, axis])
        # At the faces of cells the gradient jumps; few places lie within a step of one.
        assert np.median(off) < 1e-7 and np.quantile(off, 0.95) < 1e-6


def test_it_is_in_single_precision() -> None:
    arrays = jax.tree.leaves(eqx.filter(fresh(), eqx.is_array))
    assert {one.dtype for one in arrays} == {jnp.dtype("float32")}
