"""Between frames: exact for parabolas in the root of time, close after a lamp is lit."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import erfcx

from thermo.discover.candidates._between_frames import between_frames

COUNT = 7
found = jax.jit(between_frames)


@given(
    st.lists(st.floats(0.2, 5.0), min_size=COUNT - 1, max_size=COUNT - 1),
    st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3),
    st.lists(st.floats(0.0, 1.0), min_size=COUNT, max_size=COUNT),
)
def test_parabolas_in_the_root_of_time_are_met(
    gaps: list[float], terms: list[float], shares: list[float]
) -> None:
    time = 3.0 + np.concatenate([[0.0], np.cumsum(gaps)])
    at = time[0] + np.array(shares) * (time[-1] - time[0])

    def level(when: np.ndarray) -> np.ndarray:
        root = np.sqrt(when - time[0])
        return (300.0 + terms[0] + terms[1] * root + terms[2] * root**2)[:, None]

    np.testing.assert_allclose(found(level(time), time, at), level(at), atol=1e-9)


def test_before_it_begins_all_is_as_there_and_after_its_end_it_goes_on_along_a_line() -> None:
    time = np.array([0.0, 1.0, 3.0])
    body = np.array([[300.0], [304.0], [305.0]])
    level = found(body, time, np.array([-2.0, 0.0, 1.0, 3.0, 5.0]))[:, 0]
    np.testing.assert_allclose(level, [300.0, 300.0, 304.0, 305.0, 306.0], atol=1e-9)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_what_fills_up_a_run_is_not_read(count: int) -> None:
    make = np.random.default_rng(count)
    time, body = np.cumsum(make.uniform(0.5, 2.0, count)), make.normal(300.0, 5.0, (count, 2))
    longer = np.r_[time, np.repeat(time[-1], 3)]
    filled = np.concatenate([body, np.zeros((3, 2))])
    at = np.linspace(time[0] - 1, time[-1] + 1, 23)
    np.testing.assert_allclose(found(filled, longer, at), found(body, time, at), atol=1e-9)


def test_two_frames_make_a_line_in_the_root() -> None:
    time, body = np.array([0.0, 4.0]), np.array([[300.0], [310.0]])
    np.testing.assert_allclose(found(body, time, np.array([1.0]))[:, 0], [305.0], atol=1e-9)


@pytest.mark.parametrize("late", [0.1, 0.25, 0.4])
def test_a_cooling_skin_is_met_far_better_than_by_lines(late: float) -> None:
    # Carslaw and Jaeger, section 2.7: a half-space that cools by convection from the start.
    time = np.arange(0.0, 20.0, 0.5)
    at = time + late

    def skin(when: np.ndarray) -> np.ndarray:
        return 300.0 + 50.0 * erfcx(0.3 * np.sqrt(when))

    right = skin(at)[:-1]
    curved = found(skin(time)[:, None], time, at)[:-1, 0] - right
    straight = np.interp(at, time, skin(time))[:-1] - right
    assert np.abs(curved).max() < 0.03 * np.abs(straight).max()


def test_the_slope_where_nothing_is_late_is_that_of_time() -> None:
    time = np.arange(0.0, 10.0, 0.5)
    body = (300.0 + 2.0 * time)[:, None]

    def read(late: jax.Array) -> jax.Array:
        return between_frames(jnp.asarray(body), jnp.asarray(time), jnp.asarray(time) + late)

    _, slope = jax.jvp(read, (jnp.asarray(0.0),), (jnp.asarray(1.0),))
    assert slope[0, 0] == 0, "before the first frame it stood still"
    np.testing.assert_allclose(slope[1:, 0], 2.0, atol=1e-9)
