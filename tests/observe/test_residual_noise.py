"""Noise from residuals: found where it is noise, and a misfit is not taken for it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.observe import Recording, ResidualNoise, residual_noise

FRAMES, SIDE = 120, 12
TIME = np.arange(FRAMES, dtype=float)


def places() -> np.ndarray:
    """A grid of samples a millimetre apart, none of them exactly."""
    grid = np.stack(np.meshgrid(np.arange(SIDE), np.arange(SIDE), [0.0]), -1).reshape(-1, 3)
    return 1e-3 * (grid + 0.2 * np.random.default_rng(0).random(grid.shape))


POINTS = places()


def fluctuation(white: float, kept: float, offset: float, seed: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    made = white * random.standard_normal((FRAMES, len(POINTS)))
    for frame in range(1, FRAMES):
        made[frame] = kept * made[frame - 1] + np.sqrt(1 - kept**2) * made[frame]
    return made + offset * random.standard_normal(len(POINTS))


def misfit(size: float) -> np.ndarray:
    """Grows over the run, and varies over the whole body."""
    return size * np.outer(np.sin(TIME / 40.0), 1.0 + np.sin(150 * POINTS[:, 0]))


def found(residual: np.ndarray, every: int = 1) -> ResidualNoise:
    record = Recording(POINTS, TIME, 300.0 - residual)
    noise = residual_noise(record, residual[::every], np.arange(FRAMES)[::every])
    assert noise is not None
    return noise


@settings(max_examples=15, deadline=None)
@given(st.floats(0.02, 0.2), st.floats(0.0, 0.6), st.floats(0.0, 2.0), st.integers(0, 2**31))
def test_level_correlation_and_offsets_come_back_beside_a_smooth_misfit(
    white: float, kept: float, ratio: float, seed: int
) -> None:
    made = found(fluctuation(white, kept, ratio * white, seed) + misfit(5 * white))
    assert made.noise.white == pytest.approx(white, rel=0.1)
    assert made.noise.correlation == pytest.approx(kept, abs=0.1)
    # The robust spread of a hundred values is known to a tenth and a half.
    assert made.noise.offset == pytest.approx(ratio * white, rel=0.4, abs=0.25 * white)
    assert made.apart == pytest.approx(1e-3, rel=0.2)


def test_white_noise_has_no_offset_and_nothing_to_warn_of() -> None:
    told = [found(fluctuation(0.05, 0.0, 0.0, seed)) for seed in range(20)]
    assert np.mean([one.noise.offset for one in told]) < 0.005
    assert sum("as the noise model" in one.words() for one in told) >= 14
    assert all(one.changing == 0.0 for one in told) and max(abs(one.z) for one in told) < 5


def test_a_misfit_that_differs_between_neighbours_and_over_time_is_called_one() -> None:
    rough = 0.2 * np.outer(TIME / TIME[-1], np.random.default_rng(2).standard_normal(len(POINTS)))
    made = found(fluctuation(0.05, 0.0, 0.0, 0) + rough)
    assert made.changing == pytest.approx(0.1, rel=0.3)
    assert "a misfit and no noise" in made.words()
    # What is slow hardly shows from one frame to the next.
    assert made.noise.white == pytest.approx(0.05, rel=0.1)


def test_offsets_are_told_with_how_far_apart_samples_lie() -> None:
    words = found(fluctuation(0.05, 0.0, 0.1, 0)).words()
    assert "Neighbours, 0.92 mm apart, differ by 0.1" in words


def test_frames_that_oscillate_are_not_first_order() -> None:
    random = np.random.default_rng(0)
    fresh = 0.05 * random.standard_normal((FRAMES + 3, len(POINTS)))
    made = found(fresh[3:] + fresh[:-3])
    assert abs(made.z) > 3 and "not first-order autoregressive" in made.words()


def test_single_readings_far_off_do_not_count_and_none_is_needed() -> None:
    residual = fluctuation(0.05, 0.3, 0.05, 3)
    random = np.random.default_rng(4)
    odd = residual + 5.0 * (random.random(residual.shape) < 0.005)
    odd[random.random(odd.shape) < 0.1] = np.nan
    record = Recording(POINTS, TIME, 300.0 - residual)
    made = residual_noise(record, odd, np.arange(FRAMES))
    assert made is not None and made.noise.white == pytest.approx(0.05, rel=0.1)
    assert made.noise.correlation == pytest.approx(0.3, abs=0.1)


def test_of_fitted_frames_that_are_every_third_the_correlation_is_told_for_all() -> None:
    made = found(fluctuation(0.05, 0.8, 0.0, 5), every=3)
    assert made.noise.correlation == pytest.approx(0.8, abs=0.1)
    assert made.noise.white == pytest.approx(0.05, rel=0.15)


def test_too_little_says_nothing() -> None:
    few = fluctuation(0.05, 0.0, 0.0, 0)
    record = Recording(POINTS, TIME, 300.0 - few)
    assert residual_noise(record, few[:15], np.arange(15)) is None
    alone = Recording(POINTS[:7], TIME, 300.0 - few[:, :7])
    assert residual_noise(alone, few[:, :7], np.arange(FRAMES)) is None
