"""What is left over time: noise is white and follows nothing, a missing effect does."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.discover._trace import follows, slow_excess

FRAMES, SAMPLES, STEP = 120, 12, 0.5


def lamp() -> np.ndarray:
    return (np.arange(FRAMES) < 50).astype(float)


def test_chances_of_noise_are_even() -> None:
    random = np.random.default_rng(0)
    drawn = [random.standard_normal((FRAMES, SAMPLES)) for _ in range(200)]
    slow = [slow_excess(one) for one in drawn]
    lit = [follows(one.sum(1) / np.sqrt(SAMPLES), lamp(), STEP).p_value for one in drawn]
    # Of 200 draws 10 % is 20; outside of these once in a thousand.
    for chances in (slow, lit):
        assert 7 <= np.sum(np.array(chances) < 0.1) <= 36


def test_noise_that_fades_slowly_is_told() -> None:
    random = np.random.default_rng(1)
    wave = random.standard_normal((FRAMES, SAMPLES))
    for frame in range(1, FRAMES):
        wave[frame] = 0.4 * wave[frame - 1] + np.sqrt(1 - 0.16) * wave[frame]
    assert slow_excess(wave) < 1e-3


def test_fewer_slow_changes_than_noise_has_are_no_excess() -> None:
    fast = np.diff(np.random.default_rng(2).standard_normal((FRAMES + 1, SAMPLES)), axis=0)
    assert slow_excess(fast) > 0.9


def test_samples_that_read_nothing_do_not_count() -> None:
    left = np.random.default_rng(3).standard_normal((FRAMES, SAMPLES))
    wider = np.concatenate([left, np.zeros((FRAMES, 5))], 1)
    assert slow_excess(wider) == slow_excess(left)


@pytest.mark.parametrize("late", [0, 7])
def test_what_follows_the_lamp_is_told_with_its_lag(late: int) -> None:
    noise = np.random.default_rng(4).standard_normal(FRAMES)
    known = np.where((np.arange(FRAMES) >= 20) & (np.arange(FRAMES) < 60), 1.0, 0.0)
    answer = np.concatenate([np.zeros(late), known[: FRAMES - late]])
    found = follows(noise - 3.0 * answer, known, STEP)
    assert found.score < -10 and found.p_value == 0.0
    assert found.lag == pytest.approx(late * STEP, abs=1.0)
