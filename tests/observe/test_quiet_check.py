"""Quiet frames of the kind that is assumed, and of kinds that are not."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.observe import Noise, QuietCheck, Recording, check_quiet, estimate_noise

FRAMES, SAMPLES = 25, 300


def fluctuation(correlation: float, seed: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    found = random.standard_normal((FRAMES, SAMPLES))
    for frame in range(1, FRAMES):
        fresh = np.sqrt(1 - correlation**2) * found[frame]
        found[frame] = correlation * found[frame - 1] + fresh
    return found


def recorded(error: np.ndarray) -> Recording:
    """By a camera with errors of 50 mK times `error` beside a fixed pattern."""
    pattern = 0.03 * np.random.default_rng(9).standard_normal(error.shape[1])
    return Recording(
        np.zeros((error.shape[1], 3)), np.arange(3.0), np.full((3, error.shape[1]), 300.0),
        quiet=295.0 + 0.05 * error + pattern,
    )  # fmt: skip


def estimated(error: np.ndarray) -> Noise:
    return estimate_noise(recorded(error))


def check(error: np.ndarray) -> QuietCheck:
    record = recorded(error)
    found = check_quiet(record, estimate_noise(record))
    assert found is not None
    return found


@pytest.mark.parametrize("correlation", [0.0, 0.3, 0.6])
def test_frames_of_the_kind_that_is_assumed_pass(correlation: float) -> None:
    found = [check(fluctuation(correlation, seed)) for seed in range(60)]
    z = np.array([one.z for one in found])
    # The mean of 60 is known to 0.13 and their spread to a tenth.
    assert abs(z.mean()) < 0.45 and 0.7 < z.std() < 1.35
    assert sum(estimated(fluctuation(correlation, seed)).frame > 0 for seed in range(60)) <= 1
    assert np.mean([one.far for one in found]) < 1e-5
    assert found[0].words() == "The quiet frames are as the noise model has them."


def test_another_kind_of_fluctuation_is_seen() -> None:
    random = np.random.default_rng(0)
    fresh = random.standard_normal((FRAMES + 3, SAMPLES))
    echo = (fresh[3:] + fresh[:-3]) / np.sqrt(2)
    found = check(echo)
    assert abs(found.z) > 10 and "not first-order" in found.words()


def test_offsets_of_whole_frames_are_seen() -> None:
    random = np.random.default_rng(1)
    error = fluctuation(0.0, 0) + 0.4 * random.standard_normal((FRAMES, 1))
    assert estimated(error).frame == pytest.approx(0.4 * 0.05, rel=0.4)
    found = check(error)
    # Beside it the fluctuation is as it was.
    assert abs(found.z) < 4 and found.far == 0


def test_readings_far_out_are_seen() -> None:
    error = fluctuation(0.0, 0)
    error[np.random.default_rng(2).uniform(size=error.shape) < 0.01] += 20.0
    found = check(error)
    assert found.far == pytest.approx(0.01, rel=0.4) and "far out" in found.words()


def test_too_little_is_not_judged() -> None:
    record = Recording(np.zeros((300, 3)), np.arange(3.0), np.full((3, 300), 300.0))
    noise = estimate_noise(record)
    assert check_quiet(record, noise) is None
    for frames, samples in ((7, 300), (25, 7)):
        quiet = 295.0 + 0.05 * fluctuation(0.0, 0)[:frames, :samples]
        values = np.full((3, samples), 300.0)
        few = Recording(np.zeros((samples, 3)), np.arange(3.0), values, quiet=quiet)
        assert check_quiet(few, noise) is None


def test_samples_and_frames_that_were_never_quiet_are_left_out() -> None:
    error = fluctuation(0.0, 3)
    error[:, 5], error[4] = np.nan, np.nan
    assert abs(check(error).z) < 4


def test_frames_that_repeat_each_other_are_not_judged() -> None:
    record = Recording(
        np.zeros((300, 3)),
        np.arange(3.0),
        np.full((3, 300), 300.0),
        quiet=np.full((25, 300), 295.0),
    )
    assert check_quiet(record, estimate_noise(record)) is None
