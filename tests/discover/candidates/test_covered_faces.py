"""How much of a face lies below a level, against sums over many points of it."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.discover.candidates._covered_faces import covered

CUTS = 300
HEIGHTS = st.floats(0.0, 1.0)


def share(heights: list[float], depth: float) -> np.ndarray:
    """At the three corners."""
    found = covered(jnp.asarray(heights)[None, :, None], jnp.asarray([depth]))
    return np.asarray(found)[0, :, 0]


def even() -> np.ndarray:
    """Middles of small triangles that are alike, as barycentric coordinates."""
    one, other = np.meshgrid(np.arange(CUTS), np.arange(CUTS), indexing="ij")
    upward = np.stack([one, other], -1)[one + other < CUTS] + 1 / 3
    downward = np.stack([one, other], -1)[one + other < CUTS - 1] + 2 / 3
    two = np.concatenate([upward, downward]) / CUTS
    return np.concatenate([two, 1 - two.sum(1, keepdims=True)], 1)


EVEN = even()


@given(st.tuples(HEIGHTS, HEIGHTS, HEIGHTS), st.floats(-0.2, 1.2))
def test_its_integral_and_first_moments_are_those_of_what_is_covered(
    heights: tuple[float, float, float], depth: float
) -> None:
    inside = EVEN @ np.array(heights) < depth
    linear = EVEN @ share(list(heights), depth)
    if np.ptp(heights) > 0.05:
        wanted = (inside[:, None] * EVEN).mean(0)
        np.testing.assert_allclose((linear[:, None] * EVEN).mean(0), wanted, atol=0.02)


def test_a_face_is_whole_or_not_at_all_on_either_side_of_it() -> None:
    for heights in ([0.0, 0.0, 0.0], [0.3, 0.3, 0.3], [0.1, 0.3, 0.2]):
        np.testing.assert_allclose(share(heights, max(heights) + 1e-12), 1.0, atol=1e-9)
        np.testing.assert_array_equal(share(heights, min(heights) - 1e-12), 0.0)


def test_at_half_its_height_a_quarter_or_three_are_covered() -> None:
    assert share([0.0, 1.0, 1.0], 0.5).mean() == pytest.approx(0.25)
    assert share([0.0, 0.0, 1.0], 0.5).mean() == pytest.approx(0.75)


@given(st.permutations([0.05, 0.4, 0.9]), st.floats(0.06, 0.85))
def test_more_depth_covers_as_much_more_as_its_slope_says(
    heights: list[float], depth: float
) -> None:
    def mean(at: jax.Array) -> jax.Array:
        return covered(jnp.asarray(heights)[None, :, None], at[None]).mean()

    step, at = 1e-6, jnp.asarray(depth)
    apart = (mean(at + step) - mean(at - step)) / (2 * step)
    assert float(jax.grad(mean)(at)) == pytest.approx(float(apart), rel=1e-4)
    assert float(apart) > 0
