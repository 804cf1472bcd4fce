"""Places along rays."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from thermo.reconstruct._sampling import drawn_by_weight, stratified, within_cube

DIRECTIONS = arrays(np.float64, (5, 3), elements=st.floats(-1.0, 1.0)).filter(
    lambda d: bool((np.linalg.norm(d, axis=1) > 1e-3).all())
)
PLACES = arrays(np.float64, (5, 3), elements=st.floats(-3.0, 3.0))


@given(PLACES, DIRECTIONS)
def test_between_entry_and_exit_a_ray_is_inside_the_cube(
    origins: np.ndarray, directions: np.ndarray
) -> None:
    directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    near, far = map(np.asarray, within_cube(jnp.asarray(origins), jnp.asarray(directions)))
    hits = far > near + 1e-6
    middle = origins + (0.5 * (near + far))[:, None] * directions
    assert (np.abs(middle[hits]) <= 1 + 1e-6).all()
    # What is said to be missed has no place inside.
    along = origins[:, None] + np.linspace(0, 12, 2401)[None, :, None] * directions[:, None]
    inside = (np.abs(along) < 1 - 1e-2).all(axis=2).any(axis=1)
    assert not (inside & ~hits).any()


def test_each_equal_part_holds_one_place() -> None:
    near, far = jnp.asarray([0.0, 1.0]), jnp.asarray([2.0, 4.0])
    depths = np.asarray(stratified(near, far, 10, jax.random.key(0)))
    share = (depths - np.asarray(near)[:, None]) / np.asarray(far - near)[:, None]
    assert (np.floor(10 * share) == np.arange(10)).all()


def test_places_lie_where_the_weight_is_and_in_order() -> None:
    ends = jnp.linspace(0.0, 1.0, 11)[None]
    weight = jnp.zeros((1, 10)).at[0, 3].set(0.75).at[0, 7].set(0.25)
    drawn = np.asarray(drawn_by_weight(ends, weight, 400, jax.random.key(1)))[0]
    assert (np.diff(drawn) >= 0).all()
    first, second = (drawn > 0.3) & (drawn < 0.4), (drawn > 0.7) & (drawn < 0.8)
    assert abs(first.mean() - 0.75) < 0.005 and abs(second.mean() - 0.25) < 0.005
    # Evenly within a section.
    assert np.abs(np.quantile(drawn[first], [0.25, 0.5, 0.75]) - [0.325, 0.35, 0.375]).max() < 0.002


def test_without_any_weight_places_are_spread_evenly() -> None:
    ends = jnp.linspace(0.0, 1.0, 11)[None]
    drawn = np.asarray(drawn_by_weight(ends, jnp.zeros((1, 10)), 100, jax.random.key(1)))[0]
    assert np.abs(drawn - (np.arange(100) + 0.5) / 100).max() < 0.01
