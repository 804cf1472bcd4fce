"""What is found in recordings with and without faults."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging._frame_faults import find_faults, without_faults
from thermo.imaging._frames import Frames

ROWS, COLUMNS, NOISE = 24, 32, 0.05


def heating(seed: int, frames: int = 40, step: float | None = None) -> Frames:
    """A hump that warms by 5 K under white noise [K]; in numbers of `step` [K] where given."""
    rng = np.random.default_rng(seed)
    row, column = np.mgrid[:ROWS, :COLUMNS]
    hump = np.exp(-((row - 12) ** 2 + (column - 16) ** 2) / 72)
    course = 5.0 * (1 - np.exp(-np.linspace(0, 2, frames)))
    values = 293.0 + course[:, None, None] * hump
    values += NOISE * rng.standard_normal(values.shape)
    if step is not None:
        values = step * np.round(values / step)
    return Frames(np.arange(frames) / 10, values)


def changed(frames: Frames, values: np.ndarray) -> Frames:
    return Frames(frames.time, values, frames.valid)


@pytest.mark.parametrize("step", [None, NOISE, 5 * NOISE])
def test_clean_recordings_give_almost_no_alarm(step: float | None) -> None:
    # The chance of an alarm is below 0.02 each: more than three of twenty-five are one in 1500.
    alarms = sum(find_faults(heating(seed, step=step)).any() for seed in range(25))
    assert alarms <= 3


def test_an_object_without_noise_and_with_edges_is_clean() -> None:
    row, column = np.mgrid[:ROWS, :COLUMNS]
    thing = ((row > 5) & (row < 18) & (column > 9) & (column < 20)).astype(float)
    values = 293.0 + thing * np.linspace(3.0, 8.0, 20)[:, None, None] ** 1.5
    faults = find_faults(Frames(np.arange(20) / 5, values))
    assert not faults.any()
    assert "nothing jumps" in faults.sentences()[0]


@given(st.integers(1, 6), st.integers(2, 30))
def test_dropped_frames_are_counted(dropped: int, after: int) -> None:
    whole = heating(3)
    kept = np.r_[0 : after + 1, after + 1 + dropped : 40]
    faults = find_faults(Frames(whole.time[kept], whole.values[kept]))
    assert faults.gap.tolist() == [after]
    assert faults.missing.tolist() == [dropped]
    np.testing.assert_allclose(faults.interval, [(dropped + 1) / 10])
    assert str(after) in faults.sentences()[0]


def test_repeated_frames_are_found_and_dropped() -> None:
    frames = heating(4)
    values = frames.values.copy()
    values[7] = values[6]
    values[8] = values[6]
    frames = changed(frames, values)
    faults = find_faults(frames)
    assert faults.duplicate.tolist() == [7, 8]
    assert not faults.dead.any() and not faults.jump.size
    clean = without_faults(frames, faults)
    assert len(clean.time) == 38 and 0.7 not in clean.time
    np.testing.assert_array_equal(clean.values[7], values[9])
    assert "2 frames are the same as the one before: 7, 8." in faults.sentences()


def test_what_is_equal_only_where_invalid_is_no_duplicate() -> None:
    frames = heating(5)
    values = frames.values.copy()
    values[7] = values[6]
    values[7, 3, 3] += 0.01
    assert find_faults(changed(frames, values)).duplicate.size == 0
    valid = np.ones(values.shape, bool)
    valid[6:8, 3, 3] = False
    assert find_faults(Frames(frames.time, values, valid)).duplicate.tolist() == [7]


@pytest.mark.parametrize("step", [None, NOISE])
@pytest.mark.parametrize("seed", range(3))
def test_dead_pixels_of_every_kind_are_found(seed: int, step: float | None) -> None:
    frames = heating(seed, step=step)
    values, rng = frames.values.copy(), np.random.default_rng(9)
    dead = np.zeros((ROWS, COLUMNS), bool)
    values[:, 5, 6] = 293.0  # never changes
    values[:, 23, :] = 293.0  # nor does a whole row
    values[:, 0, 0] += 4.0  # too hot, with its noise, in a corner
    values[:, 14:16, 25:27] -= 2.0  # a block too cold
    values[:, 10, 15] += rng.normal(0.0, 0.5, 40)  # flickers, on the hump
    for place in ((5, 6), (23, slice(None)), (0, 0), (slice(14, 16), slice(25, 27)), (10, 15)):
        dead[place] = True
    frames = changed(frames, values)
    faults = find_faults(frames)
    np.testing.assert_array_equal(faults.dead, dead)
    assert not without_faults(frames, faults).valid[:, dead].any()
    assert f"{dead.sum()} pixels are dead" in " ".join(faults.sentences())


def test_a_spot_that_does_not_stay_is_not_dead() -> None:
    frames = heating(6)
    values = frames.values.copy()
    values[10, 4, 4] += 3.0
    assert not find_faults(changed(frames, values)).dead.any()
    values[:8, 4, 4] += 2.0  # nor one that passes by
    assert not find_faults(changed(frames, values)).dead.any()


@pytest.mark.parametrize("height", [0.4, -0.1])
def test_a_jump_of_the_shutter_is_told(height: float) -> None:
    frames = heating(7)
    values = frames.values.copy()
    values[22:] += height
    frames = changed(frames, values)
    faults = find_faults(frames)
    assert faults.jump.tolist() == [22]
    np.testing.assert_allclose(faults.height, [height], atol=0.03)
    assert "not repaired" in faults.sentences()[-1]
    np.testing.assert_array_equal(without_faults(frames, faults).values, values)


def test_a_lamp_that_is_switched_on_and_a_flash_are_no_jumps() -> None:
    frames = heating(8)
    row, column = np.mgrid[:ROWS, :COLUMNS]
    thing = (row > 4) & (column < 28)  # seven tenths of the image
    late = np.maximum(np.arange(40) - 20, 0.0)[:, None, None]
    ramp = frames.values + (0.5 * late).astype(np.float32)
    assert find_faults(changed(frames, ramp)).jump.size == 0
    flash = frames.values + (2.0 * (late > 0) * np.exp(-late / 5) * thing).astype(np.float32)
    assert find_faults(changed(frames, flash)).jump.size == 0


@pytest.mark.parametrize("frames", [1, 2, 3, 5])
def test_short_recordings_are_looked_at_as_far_as_they_go(frames: int) -> None:
    short = heating(0, frames)
    values = short.values.copy()
    values[:, 8, 9] += 5.0
    faults = find_faults(changed(short, values))
    assert np.argwhere(faults.dead).tolist() == [[8, 9]]


def test_pixels_that_are_never_valid_are_not_told_of_again() -> None:
    frames = heating(1)
    values = frames.values.copy()
    values[:, :4] = np.nan
    faults = find_faults(changed(frames, values))
    assert not faults.dead.any()


def test_faults_of_another_recording_are_refused() -> None:
    with pytest.raises(InputError, match="another recording's"):
        without_faults(heating(0, 10), find_faults(heating(0, 12)))
