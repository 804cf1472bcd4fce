"""Noise of runs without quiet frames: learnt, and taken into the search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from thermo.discover._learnt_noise import noise_left, taken_as_exact, with_noise
from thermo.observe import Noise, Recording, Run, estimate_noise

TIME = np.linspace(0.0, 60.0, 121)


def blind(apart: np.ndarray, seed: int, **more: object) -> Run:
    """A run without quiet frames that reads 300 K and differences [K]."""
    points = np.random.default_rng(seed).uniform(0.0, 0.03, (apart.shape[1], 3))
    record = Recording(points, TIME, 300.0 + apart)
    return Run("lamp", record, 300.0, 300.0, 300.0, **more)  # type: ignore[arg-type]


def drawn(seed: int, offset: float, kept: float, samples: int = 200) -> np.ndarray:
    """Noise of 0.05 K, of which a share is kept, on constants of samples [K]."""
    random = np.random.default_rng(seed)
    fresh = random.standard_normal((len(TIME) + 50, samples)) * 0.05 * np.sqrt(1 - kept**2)
    fluctuates = lfilter([1.0], [1.0, -kept], fresh, axis=0)[50:]
    return fluctuates + offset * random.standard_normal(samples)


@given(st.integers(0, 50), st.sampled_from([0.1, 0.3]), st.sampled_from([0.0, 0.6]))
@settings(max_examples=8)
def test_constants_of_samples_and_what_is_kept_are_told_beside_a_smooth_misfit(
    seed: int, offset: float, kept: float
) -> None:
    apart = drawn(seed, offset, kept)
    run = blind(apart, seed)
    misfit = 0.5 * np.sin(0.05 * TIME)[:, None] * np.cos(40 * run.recording.points[:, 0])
    found = noise_left(run, apart + misfit, TIME)
    assert found is not None
    told = with_noise(run, found).noise_of_readings()
    assert told.offset == pytest.approx(offset, rel=0.5)
    assert told.white == pytest.approx(0.05, rel=0.15)
    assert told.correlation == pytest.approx(kept, abs=0.15)


def test_what_is_known_is_not_learnt() -> None:
    apart = drawn(3, 0.1, 0.0)
    run = blind(apart, 3)
    quiet = replace(
        run, recording=Recording(run.recording.points, TIME, 300.0 + apart, quiet=300.0 + apart)
    )
    stated = replace(run, noise=Noise(0.05, 0.1))
    for one in (quiet, stated):
        assert noise_left(one, apart, TIME) is None and with_noise(one, None) is one
    # Too few samples for neighbours.
    few = blind(apart[:, :7], 3)
    assert noise_left(few, apart[:, :7], TIME) is None
    assert few.noise_of_readings() == estimate_noise(few.recording)


def test_runs_whose_samples_are_taken_as_exact_are_told_of() -> None:
    apart = drawn(5, 0.0, 0.0, samples=4)
    run = blind(apart, 5)
    (words,) = taken_as_exact([run, blind(apart, 5, constant_error=0.3)])
    assert words.startswith("lamp without quiet frames") and "constant_error" in words
    assert (
        taken_as_exact(
            [with_noise(run, noise_left(blind(drawn(1, 0, 0), 1), drawn(1, 0, 0), TIME))]
        )
        == []
    )
