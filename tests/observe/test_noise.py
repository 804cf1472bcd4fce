"""Noise estimates against noise that was made with known strength."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.observe import Noise, Recording, estimate_noise, variance_error


def noisy(
    white: float, offset: float, correlation: float, *, seed: int = 0, quiet: bool = True,
    frames: int = 200, samples: int = 300,
) -> Recording:  # fmt: skip
    """Cooling by 20 K with autoregressive noise, and 25 quiet frames before it."""
    generator = np.random.default_rng(seed)
    time = 0.2 * np.arange(frames)
    fluctuation = np.empty((25 + frames, samples))
    fluctuation[0] = white * generator.normal(size=samples)
    for i in range(1, len(fluctuation)):
        fresh = white * np.sqrt(1 - correlation**2) * generator.normal(size=samples)
        fluctuation[i] = correlation * fluctuation[i - 1] + fresh
    fluctuation += offset * generator.normal(size=samples)
    signal = 300.0 + 20.0 * np.exp(-time / 30.0)[:, None] * np.linspace(0.5, 1.0, samples)
    return Recording(
        np.zeros((samples, 3)), time, signal + fluctuation[25:],
        quiet=320.0 + fluctuation[:25] if quiet else None,
    )  # fmt: skip


@settings(max_examples=15, deadline=None)
@given(st.floats(0.01, 0.2), st.floats(0.02, 0.2), st.floats(0.0, 0.6), st.integers(0, 2**31))
def test_quiet_frames_give_all_three_numbers(
    white: float, offset: float, correlation: float, seed: int
) -> None:
    noise = estimate_noise(noisy(white, offset, correlation, seed=seed, frames=10))
    assert noise.white == pytest.approx(white, rel=0.12)
    assert noise.offset == pytest.approx(offset, rel=0.25, abs=0.15 * white)
    assert noise.correlation == pytest.approx(correlation, abs=0.1)


@pytest.mark.parametrize("samples", [8, 300])
@pytest.mark.parametrize("correlation", [0.0, 0.5])
def test_what_whole_frames_are_off_by_is_told_from_the_rest(
    samples: int, correlation: float
) -> None:
    found = []
    for seed in range(60):
        record = noisy(0.05, 0.03, correlation, seed=seed, frames=3, samples=samples)
        assert estimate_noise(record).frame == 0.0 or samples == 300
        common = 0.04 * np.random.default_rng(seed).standard_normal((25, 1))
        quiet = record.quiet + common
        found.append(estimate_noise(Recording(record.points, record.time, record.temperature,
                                              quiet=quiet)))  # fmt: skip
    # The spread of 25 frames is known to 16 %, its mean over 60 to 2 %.
    assert np.mean([one.frame for one in found]) == pytest.approx(0.04, rel=0.12)
    assert np.mean([one.white for one in found]) == pytest.approx(0.05, rel=0.1)
    assert np.mean([one.correlation for one in found]) == pytest.approx(correlation, abs=0.07)
    whole = np.sqrt(found[0].white ** 2 + found[0].frame ** 2)
    assert found[0].fluctuation() == pytest.approx(whole)


@settings(max_examples=15, deadline=None)
@given(st.floats(0.01, 0.2), st.integers(0, 2**31))
def test_record_alone_gives_the_white_part(white: float, seed: int) -> None:
    noise = estimate_noise(noisy(white, 0.5, 0.0, seed=seed, quiet=False))
    assert noise.white == pytest.approx(white, rel=0.05)
    assert noise.offset == 0.0 and noise.correlation == 0.0


def test_uneven_frames_and_a_switching_lamp_do_not_count() -> None:
    recording = noisy(0.05, 0.0, 0.0, quiet=False)
    keep = np.sort(np.random.default_rng(1).choice(200, 150, replace=False))
    temperature = recording.temperature[keep].copy()
    temperature[75:] += 5.0
    found = estimate_noise(Recording(recording.points, recording.time[keep], temperature))
    assert found.white == pytest.approx(0.05, rel=0.05)


@pytest.mark.parametrize("quiet", [True, False])
def test_missing_values_do_not_count(quiet: bool) -> None:
    recording = noisy(0.05, 0.03, 0.0, quiet=quiet)
    temperature = recording.temperature.copy()
    temperature[::7, ::3] = np.nan
    silent = None if recording.quiet is None else recording.quiet.copy()
    if silent is not None:
        silent[::4] = np.nan
        silent[:, 5] = np.nan
    found = estimate_noise(Recording(recording.points, recording.time, temperature, quiet=silent))
    assert found.white == pytest.approx(0.05, rel=0.1)
    assert found.offset == pytest.approx(0.03 if quiet else 0.0, rel=0.2)


@pytest.mark.parametrize("step", [0.1, 1e-3, 1e-4])
def test_rounding_is_the_floor(step: float) -> None:
    time = np.linspace(0, 10, 400)
    signal = 300 + step * 8 * np.sin(time[:, None] + np.arange(50))
    temperature = np.round(signal / step) * step
    found = estimate_noise(Recording(np.zeros((50, 3)), time, temperature))
    assert found.white >= 0.999 * step / np.sqrt(12)
    assert found.white < 1.5 * step


def test_noise_is_never_zero() -> None:
    flat = Recording(np.zeros((2, 3)), np.arange(5.0), np.full((5, 2), 300.0))
    quiet = Recording(
        np.zeros((1, 3)), np.arange(2.0), np.full((2, 1), 300.0), quiet=np.full((4, 1), 300.0)
    )
    short = Recording(np.zeros((2, 3)), np.arange(2.0), np.array([[300.0, 301.0], [302.0, 303.0]]))
    for recording in (flat, quiet, short):
        assert 0.0 < estimate_noise(recording).white < 1e-3


def test_total_adds_variances() -> None:
    assert Noise(white=0.03, offset=0.04).total() == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("correlation", "quiet"), [(0.0, True), (0.3, True), (0.5, True), (0.0, False)]
)
def test_how_far_the_variance_may_be_off_is_how_far_it_scatters(
    correlation: float, quiet: bool
) -> None:
    drawn = [
        noisy(0.05, 0.0, correlation, seed=seed, quiet=quiet, frames=100, samples=20)
        for seed in range(150)
    ]
    variances = np.array([estimate_noise(one).white ** 2 for one in drawn])
    told = variance_error(drawn[0])
    assert told == pytest.approx(np.std(variances) / np.mean(variances), rel=0.35)


def test_common_errors_are_told_where_readings_are_missing() -> None:
    record = noisy(0.05, 0.03, 0.0, frames=3)
    assert record.quiet is not None
    quiet = record.quiet + 0.04 * np.random.default_rng(7).standard_normal((25, 1))
    quiet[:, 4], quiet[6], quiet[9, 1:], quiet[::3, ::2] = np.nan, np.nan, np.nan, np.nan
    found = estimate_noise(Recording(record.points, record.time, record.temperature, quiet=quiet))
    assert found.frame == pytest.approx(0.04, rel=0.5)
    assert found.white == pytest.approx(0.05, rel=0.05)
