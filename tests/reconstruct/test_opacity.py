"""Opacity of sections and their weights, against closed forms on a plane."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from thermo.reconstruct._opacity import section_opacity, weights

RUNS = arrays(np.float64, (3, 12), elements=st.floats(-2.0, 2.0))


def test_on_a_plane_the_weights_are_the_fall_of_the_logistic_function() -> None:
    # Head on, f(t) = d - t: the sections telescope, so that any cut gives the same sums.
    distance, sharpness = 0.7, jnp.asarray(40.0)
    ends = jnp.concatenate([jnp.linspace(0.0, 0.6, 7), jnp.linspace(0.61, 1.2, 60)])
    f = distance - ends
    weight = weights(section_opacity(f[:-1], f[1:], sharpness))
    met = 1.0 - jax.nn.sigmoid(sharpness * f[1:]) / jax.nn.sigmoid(sharpness * f[0])
    assert np.allclose(np.cumsum(weight), met, atol=1e-12)
    assert float(weight.sum()) == pytest.approx(1.0, abs=1e-7)


@pytest.mark.parametrize("slope", [1.0, 0.5, 0.2])
def test_weights_are_highest_on_the_surface_from_whatever_side(slope: float) -> None:
    ends = jnp.linspace(0.0, 1.5, 301)
    f = slope * (0.7025 - ends)
    density = weights(section_opacity(f[:-1], f[1:], jnp.asarray(80.0))) / jnp.diff(ends)
    middle = 0.5 * (ends[1:] + ends[:-1])
    # The logistic function's slope is even about the surface, and so is the density to first order.
    assert float(middle[jnp.argmax(density)]) == pytest.approx(0.7025, abs=0.005)


@given(RUNS, st.floats(0.1, 1000.0))
def test_weights_are_shares_of_one(f: np.ndarray, sharpness: float) -> None:
    opacity = section_opacity(jnp.asarray(f[:, :-1]), jnp.asarray(f[:, 1:]), jnp.asarray(sharpness))
    weight = np.asarray(weights(opacity))
    assert (weight >= 0).all() and (weight.sum(axis=1) <= 1 + 1e-12).all()
    leaving = f[:, 1:] >= f[:, :-1]
    assert (weight[leaving] == 0).all()


def test_the_nearer_of_two_surfaces_hides_the_other() -> None:
    ends = jnp.linspace(0.0, 2.0, 401)
    f = jnp.minimum(jnp.abs(ends - 0.6), jnp.abs(ends - 1.4)) - 0.1
    weight = weights(section_opacity(f[:-1], f[1:], jnp.asarray(200.0)))
    middle = 0.5 * (ends[1:] + ends[:-1])
    assert float(weight[middle > 1.0].sum()) < 1e-6 < float(weight[middle < 0.6].sum())


def test_deep_inside_single_precision_keeps_its_shares() -> None:
    f = jnp.asarray([[0.5, -0.5, -0.6]], jnp.float32)
    opacity = section_opacity(f[:, :-1], f[:, 1:], jnp.asarray(500.0, jnp.float32))
    assert np.isfinite(opacity).all() and float(opacity[0, 1]) == pytest.approx(1.0)


def test_its_derivative_leaves_a_remainder_of_second_order() -> None:
    key = jax.random.key(2)
    f = jnp.sort(jax.random.normal(key, (4, 9)), axis=1)[:, ::-1] * 0.1
    way = jax.random.normal(jax.random.key(3), f.shape) * 0.1

    def colour(f: jax.Array, sharpness: jax.Array) -> jax.Array:
        weight = weights(section_opacity(f[:, :-1], f[:, 1:], sharpness))
        return jnp.sum(weight * jnp.arange(8.0))

    at = (f, jnp.asarray(20.0))
    along = (way, jnp.asarray(5.0))
    value, slope = jax.jvp(colour, at, along)
    rest = []
    for size in (1e-2, 5e-3, 2.5e-3):
        moved = colour(at[0] + size * along[0], at[1] + size * along[1])
        rest.append(abs(float(moved - value - size * slope)))
    rates = np.log2(np.asarray(rest[:-1]) / np.asarray(rest[1:]))
    assert (rates > 1.9).all()
