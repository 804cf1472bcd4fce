"""Quiet frames tell a camera of another scale from a lamp of another power."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lit_box import HOT, LAMP, POINTS, run

from thermo.discover._at_rest import KNOWN, rest_residual
from thermo.discover.candidates import CameraEmissivity, ClockOffset, HeaterPower, SensorLag
from thermo.inverse import Case

from .lit_objective import objective

RUNS = (run("lamp", lamp=LAMP, quiet=True), run("hot", initial=HOT, quiet=True))
COLD = RUNS[0].initial_temperature


@pytest.fixture(scope="module")
def cases() -> tuple[Case, ...]:
    """Two runs with quiet frames, one of a warm body, seen by a camera that is right."""
    return tuple(
        replace(one, resting=jnp.zeros_like(one.pinned[:, 0])) for one in objective(RUNS).cases
    )


def told(cases: tuple[Case, ...], *seen: float) -> tuple[Case, ...]:
    """The same with what was read wrongly before each run [K]."""
    (case,) = cases
    return (replace(case, resting=jnp.asarray(seen)),)


@settings(max_examples=25, deadline=None)
@given(st.floats(-0.2, 0.2), st.floats(-5.0, 5.0))
def test_a_camera_of_another_scale_reads_a_warm_body_wrongly_before_its_run(
    cases: tuple[Case, ...], strength: float, common: float
) -> None:
    wrong = CameraEmissivity(jnp.asarray([strength]))
    (case,) = cases
    starts = np.asarray(case.under.initial) - np.asarray(case.under.surroundings)
    seen = strength * starts + common
    # What is off in all runs alike tells nothing.
    np.testing.assert_allclose(rest_residual(told(cases, *seen), (wrong,)), 0, atol=1e-9)
    without = np.asarray(rest_residual(told(cases, *seen), ()))
    apart = strength * np.ptp(starts) / KNOWN
    assert np.linalg.norm(without) == pytest.approx(abs(apart) / 2**0.5, abs=1e-9)


def test_what_does_not_change_a_reading_at_rest_is_not_told_of(cases: tuple[Case, ...]) -> None:
    seen = told(cases, 0.3, -0.4)
    late = (ClockOffset(jnp.asarray([2.0])), SensorLag(jnp.asarray([3.0])))
    strong = HeaterPower(jnp.asarray([0.5]))
    wanted = np.array([0.35, -0.35]) / KNOWN
    for some in ((), late, (strong,)):
        np.testing.assert_allclose(np.sort(rest_residual(seen, some)), np.sort(-wanted), atol=1e-9)


def test_one_run_with_quiet_frames_tells_nothing() -> None:
    wrong = (CameraEmissivity(jnp.asarray([0.2])),)
    alone = objective((run("hot", initial=HOT, quiet=True), run("lamp", lamp=LAMP)))
    assert np.all(np.asarray(rest_residual(alone.cases, wrong)) == 0)


def test_a_fit_knows_what_quiet_frames_read() -> None:
    (case,) = objective(RUNS).cases
    for row, one in enumerate(RUNS):
        assert one.recording.quiet is not None
        mean = np.mean(one.recording.quiet - one.initial_temperature)
        assert case.resting is not None
        assert float(case.resting[row]) == pytest.approx(mean)
    assert len(POINTS) == case.pinned.shape[1] and COLD < HOT


def test_a_start_that_was_read_off_quiet_frames_tells_nothing_of_them() -> None:
    hot = RUNS[1]
    level = float(np.mean(np.asarray(hot.recording.quiet)))
    (case,) = objective((RUNS[0], replace(hot, initial_temperature=level))).cases
    assert np.array_equal(np.isnan(np.asarray(case.resting)), [False, True])
    wrong = (CameraEmissivity(jnp.asarray([0.2])),)
    assert np.all(np.asarray(rest_residual((case,), wrong)) == 0)
