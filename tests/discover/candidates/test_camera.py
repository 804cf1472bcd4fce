"""Effects on what is read: none at strength zero, and closed forms on straight lines."""

from __future__ import annotations

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lit_box import AIR, FRAMES, OFF, change, hot, lit, nearest, one, without

from thermo.discover import Candidate
from thermo.discover.candidates import CameraDrift, CameraEmissivity, ClockOffset, SensorLag
from thermo.inverse import Conditions
from thermo.inverse._addition import read_as

MADE: dict[str, Callable[[float], Candidate]] = {
    "sensor_lag": lambda value: SensorLag(one(value)),
    "clock_offset": lambda value: ClockOffset(one(value)),
    "camera_emissivity": lambda value: CameraEmissivity(one(value)),
    "camera_drift": lambda value: CameraDrift(one(value)),
}
LIT = nearest((0.013, 0.006, 0.008))
# Of one length, so that they share their programs.
COUNT = 9
TIMES = st.lists(st.floats(0.2, 5.0), min_size=COUNT - 1, max_size=COUNT - 1).map(
    lambda gaps: np.concatenate([[0.0], np.cumsum(gaps)])
)


def read(candidate: Candidate, body: np.ndarray, time: np.ndarray) -> np.ndarray:
    """What is read [K] of temperatures [K] at times [s], by one sample for each column."""
    pinned = jnp.zeros(body.shape[1])
    return np.asarray(_read(jnp.asarray(body), jnp.asarray(time), hot(), pinned, (candidate,)))


_read = eqx.filter_jit(read_as)


def ramp(time: np.ndarray, rate: float) -> np.ndarray:
    return (300.0 + rate * time)[:, None]


@pytest.mark.parametrize("under", [hot(), lit()], ids=["hot", "lit"])
@pytest.mark.parametrize("name", list(MADE))
def test_strength_zero_changes_nothing(name: str, under: Conditions) -> None:
    candidate = MADE[name](0.0)
    assert candidate.card.name == name
    assert np.abs(change(candidate, under)).max() < 1e-9


@pytest.mark.parametrize(
    ("name", "strength", "sign"),
    [
        # A slow sensor reads less of what warms; frames that are late read more of it.
        ("sensor_lag", 2.0, -1),
        ("clock_offset", 2.0, 1),
        ("clock_offset", -2.0, -1),
        ("camera_emissivity", 0.2, 1),
        ("camera_emissivity", -0.2, -1),
    ],
)
def test_a_strength_shows_where_the_lamp_shines(name: str, strength: float, sign: int) -> None:
    moved = change(MADE[name](strength), lit())[:, LIT]
    warming = (FRAMES > 0) & (FRAMES < OFF - 2)
    assert np.all(sign * moved[warming] > 0.1)
    cooling = FRAMES > OFF + 6
    turned = name != "camera_emissivity"
    assert np.all((-sign if turned else sign) * moved[cooling] > 0)


@given(TIMES, st.floats(-3.0, 3.0), st.floats(0.1, 20.0))
def test_a_slow_sensor_on_a_ramp(time: np.ndarray, rate: float, lag: float) -> None:
    body = ramp(time, rate)
    found = read(SensorLag(one(lag)), body, time)[:, 0] - body[:, 0]
    np.testing.assert_allclose(found, -lag * rate * (1 - np.exp(-time / lag)), atol=1e-9)


def test_a_slow_sensor_lags_by_its_time_constant_after_a_while() -> None:
    time = np.linspace(0.0, 40.0, 21)
    body = ramp(time, 0.7)
    found = read(SensorLag(one(3.0)), body, time)[:, 0]
    np.testing.assert_allclose(found[-3:], body[-3:, 0] - 3.0 * 0.7, atol=1e-4)
    assert found[0] == body[0, 0], "it begins at the first temperature"


def test_a_slow_sensor_follows_any_line_from_frame_to_frame() -> None:
    make = np.random.default_rng(0)
    time = np.cumsum(make.uniform(0.3, 2.0, 9))
    body = 300.0 + make.normal(0, 5, (9, 3))
    lag, many = 1.7, 20000
    found = read(SensorLag(one(lag)), body, time)
    fine = np.linspace(time[0], time[-1], many)
    level = np.stack([np.interp(fine, time, column) for column in body.T], 1)
    value, step = level[0], fine[1] - fine[0]
    followed = [value]
    for middle in 0.5 * (level[1:] + level[:-1]):
        value = middle + (value - middle) * np.exp(-step / lag)
        followed.append(value)
    wanted = np.stack([np.interp(time, fine, column) for column in np.array(followed).T], 1)
    np.testing.assert_allclose(found, wanted, atol=2e-3)


def test_the_slope_by_a_lag_that_is_absent_is_the_slope_before_each_frame() -> None:
    time = np.array([0.0, 1.0, 3.0, 4.0])
    body = np.array([[300.0], [304.0], [302.0], [303.0]])

    def at(strength: jax.Array) -> jax.Array:
        return SensorLag(strength).to_readings(jnp.asarray(body), jnp.asarray(time), hot())

    _, slope = jax.jvp(at, (one(0.0),), (one(1.0),))
    np.testing.assert_allclose(slope[:, 0], [0.0, -4.0, 1.0, -1.0], atol=1e-12)


def test_the_slope_by_a_lag_leaves_a_square() -> None:
    body = jnp.asarray(without(AIR, 1.2))

    def at(strength: jax.Array) -> jax.Array:
        return SensorLag(strength).to_readings(body, jnp.asarray(FRAMES), lit())

    value, slope = jax.jvp(at, (one(2.0),), (one(1.5),))
    shares = 0.5 ** np.arange(1, 6)
    rest = [np.linalg.norm(at(one(2.0 + 1.5 * h)) - value - h * slope) for h in shares]
    assert np.linalg.norm(slope) > 0.1
    assert np.polyfit(np.log(shares), np.log(rest), 1)[0] > 1.9


@given(st.floats(0.2, 5.0), st.floats(-3.0, 3.0), st.floats(0.0, 9.0))
def test_a_late_clock_on_a_ramp(gap: float, rate: float, late: float) -> None:
    time = gap * np.arange(COUNT)
    offset = late * gap
    found = read(ClockOffset(one(offset)), ramp(time, rate), time)
    np.testing.assert_allclose(found[:, 0], 300.0 + rate * (time + offset), atol=1e-9)


@given(TIMES, st.floats(-3.0, 3.0), st.floats(0.1, 8.0))
def test_an_early_clock_on_a_ramp(time: np.ndarray, rate: float, early: float) -> None:
    found = read(ClockOffset(one(-early)), ramp(time, rate), time)
    # Before it begins, a run is as it begins.
    np.testing.assert_allclose(found[:, 0], 300.0 + rate * np.maximum(time - early, 0.0), atol=1e-9)


def test_a_late_clock_goes_on_as_the_last_frames_do() -> None:
    # Frames that are thinned out evenly may have a last interval that is the shortest.
    time = np.array([0.0, 2.0, 4.0, 5.0])
    found = read(ClockOffset(one(0.5)), ramp(time, 1.0), time)
    np.testing.assert_allclose(found[:, 0], 300.0 + time + 0.5, atol=1e-9)


def test_a_clock_reads_a_run_that_was_filled_up_as_it_reads_the_run() -> None:
    # A run that others outlast is filled up by its last time; what stands there is no reading.
    time, body = np.array([0.0, 2.0, 4.0, 6.0]), ramp(np.array([0.0, 2.0, 4.0, 6.0]), 1.0)
    longer = np.r_[time, time[-1:], time[-1:]]
    filled = np.concatenate([body, np.zeros((2, 1))])
    for offset in (0.0, 0.5, -0.5):
        found = read(ClockOffset(one(offset)), filled, longer)[:4]
        wanted = read(ClockOffset(one(offset)), body, time)
        np.testing.assert_allclose(found, wanted, atol=1e-9)


def test_a_camera_s_scale_is_a_factor_above_what_is_reflected() -> None:
    body = np.array([[AIR - 10.0, AIR, AIR + 40.0]])
    found = read(CameraEmissivity(one(0.15)), np.repeat(body, 2, 0), np.array([0.0, 1.0]))
    np.testing.assert_allclose(found[0] - AIR, 1.15 * (body[0] - AIR), atol=1e-9)


@pytest.mark.parametrize("name", list(MADE))
def test_a_sample_whose_constant_error_is_taken_off_reads_its_start(name: str) -> None:
    candidate = MADE[name](0.3)
    under = hot()
    start = float(under.initial)
    body = jnp.asarray(start + np.array([[0.0, 0.0], [-3.0, -3.0]]))
    time, pinned = jnp.asarray([0.0, 2.0]), jnp.asarray([1.0, 0.0])
    found = np.asarray(read_as(body, time, under, pinned, (candidate,)))
    before = 0.3 * (start - AIR) if name == "camera_emissivity" else 0.0
    # Its quiet frames showed what the camera makes of the start.
    assert found[0, 0] == pytest.approx(found[0, 1] - before, abs=1e-9)
    assert found[1, 0] == pytest.approx(found[1, 1] - before, abs=1e-9)


def test_a_drift_grows_with_time_wherever_it_is_read() -> None:
    time = np.array([0.0, 1.0, 4.0])
    body = np.array([[300.0, 310.0], [301.0, 309.0], [302.0, 305.0]])
    more = read(CameraDrift(one(0.1)), body, time) - body
    np.testing.assert_allclose(more, 0.1 * time[:, None] * np.ones((1, 2)), atol=1e-12)
    assert CameraDrift.card.fault
