"""A camera's noise: the levels that were asked for, found again by the estimate of noise."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.observe import Recording, estimate_noise, with_camera_noise

START = 295.0


def recording() -> Recording:
    points = np.random.default_rng(0).uniform(size=(400, 3))
    time = np.arange(100.0)
    return Recording(points, time, np.full((100, 400), START))


def test_the_levels_are_those_that_were_asked_for() -> None:
    noisy = with_camera_noise(recording(), START, white=0.05, pattern=0.03, quiet=200)
    change = noisy.temperature - START
    assert change.mean(0).std() == pytest.approx(0.03, rel=0.12)
    assert (change - change.mean(0)).std() == pytest.approx(0.05, rel=0.02)
    found = estimate_noise(noisy)
    assert found.white == pytest.approx(0.05, rel=0.03)
    assert found.offset == pytest.approx(0.03, rel=0.12)
    assert found.correlation < 0.05
    assert noisy.quiet is not None
    # What stays is the same before the run and in it: quiet frames tell it.
    assert np.corrcoef(noisy.quiet.mean(0), change.mean(0))[0, 1] > 0.95


def test_a_seed_repeats_and_another_does_not() -> None:
    one, same, other = (with_camera_noise(recording(), START, seed=s) for s in (1, 1, 2))
    assert np.array_equal(one.temperature, same.temperature)
    assert not np.array_equal(one.temperature, other.temperature)


@pytest.mark.parametrize("level", [{"white": -1.0}, {"pattern": float("nan")}, {"quiet": -1}])
def test_levels_that_cannot_be_are_refused(level: dict[str, float]) -> None:
    with pytest.raises(InputError, match="no such noise"):
        with_camera_noise(recording(), START, **level)  # type: ignore[arg-type]


def test_what_was_not_valid_stays_so_and_quiet_frames_can_be_left_out() -> None:
    old = recording()
    valid = np.ones(old.temperature.shape, bool)
    valid[3, 7] = False
    noisy = with_camera_noise(
        Recording(old.points, old.time, old.temperature, valid), START, quiet=0
    )
    assert noisy.quiet is None and not noisy.valid[3, 7] and noisy.valid.sum() == valid.size - 1
