"""A quantity that runs linearly between points in time."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.physics.effects import History


def drawn(points: int, seed: int) -> History:
    """A history of so many points."""
    draw = np.random.default_rng(seed)
    time = jnp.asarray(np.cumsum(draw.uniform(0.1, 2.0, points)))
    return History(time, jnp.asarray(draw.normal(300.0, 10.0, points)))


@given(st.integers(1, 12), st.integers(0, 1000), st.floats(-0.2, 1.2))
def test_it_is_linear_between_points_and_constant_outside(
    points: int, seed: int, share: float
) -> None:
    history = drawn(points, seed)
    for time in (share * float(history.time[-1]), *np.asarray(history.time)):
        wanted = np.interp(time, history.time, history.value)
        assert history.at(time) == pytest.approx(wanted, abs=1e-11)


def test_the_slope_by_time_is_that_of_one_side_where_a_step_ends_on_a_point() -> None:
    history = History(jnp.array([0.0, 1.0, 3.0]), jnp.array([290.0, 300.0, 340.0]))
    slopes = [float(jax.grad(history.at)(time)) for time in (0.0, 0.5, 1.0, 2.0, -1.0, 4.0)]
    assert slopes == pytest.approx([10.0, 10.0, 20.0, 20.0, 0.0, 0.0])


def test_the_slope_by_its_values_is_each_ones_weight() -> None:
    history = History(jnp.array([0.0, 1.0, 3.0]), jnp.array([290.0, 300.0, 340.0]))
    weights = jax.grad(lambda value: History(history.time, value).at(2.5))(history.value)
    np.testing.assert_allclose(weights, [0.0, 0.25, 0.75])
