"""Offsets between a camera's clock and the heater's."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging._time_offset import time_offset

ON, LASTS, OFFSET = 20.0, 30.0, 0.37  # s


def record(
    kind: str, seed: int = 0, *, offset: float = OFFSET, rise: float = 5.0, lit: int = 100
) -> tuple[np.ndarray, np.ndarray]:
    """Ten frames a second of 100 samples with noise of 0.05 K; the first `lit` are heated."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, 80.0, 0.1)
    since = np.maximum(time - ON - offset, 0.0) / LASTS
    if kind == "thick":
        course = np.sqrt(since) - np.sqrt(np.maximum(since - 1.0, 0.0))
    else:
        course = np.minimum(since, 1.0)
    heated = np.where(np.arange(100) < lit, rise, 0.05 * rise)
    noise = 0.05 * random.normal(size=(len(time), 100))
    return time, 293.0 + course[:, None] * heated + noise


@settings(max_examples=8)
@given(st.integers(0, 1000), st.sampled_from(["thick", "thin"]), st.booleans())
def test_the_offset_is_found_between_frames(seed: int, kind: str, off: bool) -> None:
    time, temperature = record(kind, seed)
    found = time_offset(time, temperature, [ON, ON + LASTS] if off else [ON])
    assert abs(found.offset - OFFSET) < max(0.1, 3 * found.deviation)
    assert found.deviation < 0.1
    assert found.p_value < 1e-30
    if kind == "thick":
        assert found.power == 0.5
        assert abs(found.offset - OFFSET) < 0.02
    assert found.rises[0] > 0
    if off:
        assert found.rises[1] < 0


def test_rises_and_samples_are_those_of_the_heated() -> None:
    time, temperature = record("thick", lit=30)
    found = time_offset(time, temperature, [ON], window=10.0)
    assert found.samples[:30].all() and not found.samples[30:].any()
    assert found.rises[0] == pytest.approx(5 * np.sqrt((10 - OFFSET) / LASTS), rel=0.05)


@pytest.mark.parametrize("offset", [-1.234, 0.0, 2.5])
def test_offsets_of_both_signs(offset: float) -> None:
    time, temperature = record("thick", offset=offset)
    found = time_offset(time, temperature, [ON])
    assert found.offset == pytest.approx(offset, abs=0.02)


def test_missing_values_are_left_out() -> None:
    time, temperature = record("thick")
    temperature[:, :10] = np.nan
    temperature[::37, 10:60] = np.nan
    found = time_offset(time, temperature, [ON])
    assert not found.samples[:10].any()
    assert found.offset == pytest.approx(OFFSET, abs=0.02)


@settings(max_examples=8)
@given(st.integers(0, 1000))
def test_noise_and_a_steady_drift_are_no_onset(seed: int) -> None:
    time, temperature = record("thick", seed, rise=0.0)
    temperature += 0.01 * time[:, None]
    with pytest.raises(InputError, match="no onset of heating"):
        time_offset(time, temperature, [ON])


def test_what_cannot_be_told_is_refused() -> None:
    time, temperature = record("thick")
    with pytest.raises(InputError, match="too few frames about a switch"):
        time_offset(time, temperature, [2.0])
    with pytest.raises(InputError, match="no switch"):
        time_offset(time, temperature, [])
    with pytest.raises(InputError, match="does not fit time"):
        time_offset(time[:-1], temperature, [ON])
    with pytest.raises(InputError, match="above 5"):
        time_offset(time, temperature, [ON], window=3.0)
    with pytest.raises(InputError, match="seen about every switch"):
        time_offset(time, np.full_like(temperature, np.nan), [ON])


def test_an_offset_at_its_limit_is_refused() -> None:
    time, temperature = record("thick", offset=3.0)
    with pytest.raises(InputError, match="at its limit"):
        time_offset(time, temperature, [ON], most=1.0)
