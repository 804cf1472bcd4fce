"""The objective: its parts on an exact ball, and its derivative."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.reconstruct._distance_network import FIRST_RADIUS
from thermo.reconstruct._neural_surface import NeuralSurface
from thermo.reconstruct._objective import Balance, Parts, Rays, objective
from thermo.reconstruct._render_rays import Sampling, see

LEVELS = jnp.asarray(2.0)
KEY = jax.random.key(3)
DENSE = Sampling(128, 1, 128)
looked, measure = eqx.filter_jit(see), eqx.filter_jit(objective)


def ball(sharpness: float = 200.0) -> NeuralSurface:
    """The grey ball that training begins with, in double precision."""
    surface = NeuralSurface((4, 8), 2, 16, 3, key=jax.random.key(0))
    surface = eqx.tree_at(
        lambda one: one.log_sharpness, surface, jnp.asarray(np.log(sharpness) / 10)
    )
    return jax.tree.map(lambda one: one.astype(float) if eqx.is_array(one) else one, surface)


def across(heights: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Rays along x that pass the middle at `heights`."""
    origins = jnp.stack([jnp.full_like(heights, -3.0), heights, 0 * heights], axis=1)
    return origins, jnp.broadcast_to(jnp.asarray([1.0, 0.0, 0.0]), origins.shape)


def test_a_ball_is_seen_where_it_is() -> None:
    heights = jnp.linspace(-0.45, 0.45, 9)
    seen = looked(ball(), *across(heights), DENSE, LEVELS, key=KEY)
    assert np.abs(seen.covered - 1).max() < 1e-3
    depth = 3.0 - np.sqrt(FIRST_RADIUS**2 - heights**2)
    # The logistic function is one two-hundredth wide along its normal.
    assert np.abs(seen.depth - depth).max() < 0.01
    assert np.abs(seen.colour - 0.5).max() < 1e-3
    normal = jnp.stack([-jnp.sqrt(FIRST_RADIUS**2 - heights**2), heights, 0 * heights], axis=1)
    unit = seen.normal / jnp.linalg.norm(seen.normal, axis=1, keepdims=True)
    assert np.abs(unit - normal / FIRST_RADIUS).max() < 0.02


def test_the_silhouette_stands_where_half_is_covered() -> None:
    # A ray that passes at a height h over the surface is covered by Phi(-s h).
    above = jnp.asarray([-0.03, -0.02, -0.01, -0.005, 0.0, 0.005, 0.01, 0.02, 0.03])
    rays = across(FIRST_RADIUS + above)
    seen = looked(ball(), *rays, DENSE, LEVELS, key=KEY)
    assert np.abs(seen.covered - jax.nn.sigmoid(-200.0 * above)).max() < 0.01


def measured(
    surface: NeuralSurface,
    heights: jax.Array,
    mask: jax.Array,
    colour: float = 0.5,
    sampling: Sampling = DENSE,
) -> tuple[jax.Array, Parts]:
    """The objective of grey rays across the ball."""
    origins, directions = across(heights)
    rays = Rays(origins, directions, jnp.full((heights.size, 3), colour), mask)
    return measure(surface, rays, sampling, Balance(), LEVELS, key=KEY)


def test_of_an_exact_distance_and_its_own_pictures_nothing_is_left() -> None:
    heights = jnp.asarray([-0.9, -0.7, -0.55, -0.45, 0.0, 0.2, 0.45, 0.55, 0.8])
    inside = (jnp.abs(heights) < FIRST_RADIUS).astype(float)
    total, parts = measured(ball(), heights, inside)
    assert float(parts.eikonal) < 1e-5 and float(parts.colour) < 2e-3 and float(parts.mask) < 5e-3
    assert float(total) < 3e-3


@pytest.mark.parametrize(("colour", "apart"), [(0.7, 0.2), (0.1, 0.4)])
def test_colours_count_by_channel_over_pixels_of_the_object(colour: float, apart: float) -> None:
    heights = jnp.linspace(-0.4, 0.4, 9)
    _, parts = measured(ball(), heights, jnp.ones(9), colour)
    assert float(parts.colour) == pytest.approx(3 * apart, abs=2e-3)
    assert float(parts.square) == pytest.approx(apart**2, abs=2e-3)


def test_a_wrong_silhouette_costs_its_cross_entropy() -> None:
    heights = jnp.linspace(-0.4, 0.4, 9)
    _, right = measured(ball(), heights, jnp.ones(9))
    _, wrong = measured(ball(), heights, jnp.zeros(9))
    # Coverage is clipped to a thousandth from nothing and all.
    assert float(right.mask) == pytest.approx(-np.log(0.999), abs=1e-3)
    assert float(wrong.mask) == pytest.approx(-np.log(0.001), abs=1e-2)


def test_a_stretched_ball_is_no_distance() -> None:
    surface = ball()
    layers = surface.distance.layers
    # m = x: the gradient is n + e_x instead of n.
    first = jnp.zeros_like(layers.weights[0]).at[0, 0].set(1.0)
    last = jnp.zeros_like(layers.weights[1]).at[0, 0].set(1.0)
    bias = jnp.full_like(layers.biases[0], 2.0)
    surface = eqx.tree_at(
        lambda one: (one.distance.layers.weights, one.distance.layers.biases), surface,
        ((first, last), (bias, layers.biases[1])),
    )  # fmt: skip
    _, parts = measured(surface, jnp.linspace(-0.4, 0.4, 9), jnp.ones(9))
    assert float(parts.eikonal) > 0.3


def test_its_derivative_leaves_a_remainder_of_second_order() -> None:
    arrays, static = eqx.partition(ball(30.0), eqx.is_array)
    leaves, shape = jax.tree.flatten(arrays)
    keys = jax.random.split(jax.random.key(8), 2 * len(leaves))
    spread = [0.1 * jax.random.normal(k, one.shape) for k, one in zip(keys, leaves, strict=False)]
    start = [one + more for one, more in zip(leaves[:-1], spread[:-1], strict=True)] + leaves[-1:]
    way = [jax.random.normal(k, one.shape) for k, one in zip(keys[::-1], leaves, strict=False)]
    heights = jnp.linspace(-0.6, 0.6, 9)
    mask = jnp.where(jnp.abs(heights) < 0.4, 1.0, 0.2)
    # Where a ray is looked at follows the surface, and is held as it is when weights are learned.
    held = Sampling(48, 0, 48)

    def cost(leaves: list[jax.Array]) -> jax.Array:
        surface = eqx.combine(jax.tree.unflatten(shape, leaves), static)
        return measured(surface, heights, mask, 0.3, held)[0]

    # One program serves all: it gives the slope at the other places too, where none is asked for.
    both = jax.jit(jax.value_and_grad(cost))
    value, slope = both(start)
    along = sum(float(jnp.vdot(a, b)) for a, b in zip(slope, way, strict=True))
    rest = []
    for size in (4e-4, 2e-4, 1e-4):
        moved, _ = both([a + size * b for a, b in zip(start, way, strict=True)])
        rest.append(abs(float(moved - value) - size * along))
    assert abs(along) > 1e3 * rest[-1]
    rates = np.log2(np.asarray(rest[:-1]) / np.asarray(rest[1:]))
    assert (rates > 1.8).all(), rates
