"""From stored numbers to kelvin or counts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging.readers import Stated
from thermo.imaging.readers._values import frames_of, unit_named

RATE = 10.0


def stack(value: float, kind: type = np.float32) -> np.ndarray:
    return np.full((3, 4, 5), value).astype(kind)


def test_floats_are_kelvin_and_single_precision_is_not_copied() -> None:
    values = stack(300.0)
    frames = frames_of(values, Stated(rate=RATE), where="x")
    assert np.shares_memory(frames.values, values)
    assert not frames.counts


def test_whole_numbers_are_counts_unless_scaled() -> None:
    raw = stack(29815, np.uint16)
    frames = frames_of(raw, Stated(rate=RATE), where="x")
    assert frames.counts and frames.values.dtype == np.float32
    scaled = frames_of(raw, Stated(rate=RATE, scale=0.01), where="x")
    assert not scaled.counts
    np.testing.assert_allclose(scaled.values, 298.15, atol=2e-5)


@given(st.integers(1000, 60000), st.floats(1e-3, 0.1), st.floats(-20.0, 20.0))
def test_scale_and_offset_are_exact_to_single_precision(
    raw: int, scale: float, offset: float
) -> None:
    kelvin = scale * raw + offset
    if not 150.0 <= kelvin <= 5000.0:
        return
    given_ = Stated(rate=RATE, scale=scale, offset=offset)
    got = frames_of(stack(raw, np.uint16), given_, where="x").values
    np.testing.assert_allclose(got, kelvin, rtol=1e-7)


def test_celsius_becomes_kelvin_whoever_says_so() -> None:
    for stated, said in ((Stated(rate=RATE, unit="C"), None), (Stated(rate=RATE), "C")):
        got = frames_of(stack(25.0, np.float64), stated, where="x", unit=said)
        np.testing.assert_allclose(got.values, 298.15, atol=2e-5)


def test_kelvin_called_celsius_and_celsius_called_kelvin_are_refused() -> None:
    with pytest.raises(InputError, match="look like kelvin") as caught:
        frames_of(stack(298.0), Stated(rate=RATE, unit="C"), where="film.npy")
    assert "film.npy" in str(caught.value) and "recording.unit=K" in str(caught.value)
    for unit in (None, "K"):
        with pytest.raises(InputError, match="cannot be kelvin") as caught:
            frames_of(stack(25.0), Stated(rate=RATE, unit=unit), where="film.npy")
        assert "film.npy" in str(caught.value) and "recording.unit=C" in str(caught.value)


def test_a_hot_plate_before_a_room_may_be_celsius() -> None:
    values = stack(300.0)
    values[:, 0, 0] = 20.0
    got = frames_of(values, Stated(rate=RATE, unit="C"), where="x")
    assert got.values.max() == np.float32(573.15)


@pytest.mark.parametrize(
    ("values", "said", "stated", "part"),
    [
        (stack(25), "C", {"unit": "K"}, "different units"),
        (stack(9000, np.uint16), "counts", {"scale": 0.01}, "counts have no scale"),
        (stack(200, np.uint8), None, {}, "eight bits"),
        (stack(300.0)[None], None, {}, "these are no frames"),
        (stack(300.0)[:0], None, {}, "these are no frames"),
        (np.array([["a"]]), None, {}, "plain numbers"),
        (np.array([[None]]), None, {}, "plain numbers"),
        (stack(20000), None, {"unit": "K"}, "raw camera counts"),
        (np.full((2, 2, 2), 1e300), None, {}, "infinite values"),
    ],
)
def test_what_cannot_be_frames_is_refused(
    values: np.ndarray, said: str | None, stated: dict, part: str
) -> None:
    with pytest.raises(InputError) as caught:
        frames_of(values, Stated(rate=RATE, **stated), where="film.npy", unit=said)
    assert part in str(caught.value) and "film.npy" in str(caught.value)


def test_a_frame_of_nan_is_named() -> None:
    values = stack(300.0)
    values[1] = np.nan
    with pytest.raises(InputError, match="without any value") as caught:
        frames_of(values, Stated(rate=RATE), where="dir", names=["a.csv", "b.csv", "c.csv"])
    assert "dir: b.csv" in str(caught.value) and "frame 1" in str(caught.value)


def test_frames_and_stated_times_of_different_number_are_refused() -> None:
    with pytest.raises(InputError, match="3 frames, 2 times"):
        frames_of(stack(300.0), Stated(times=[0.0, 1.0]), where="x")


def test_units_have_many_names_but_not_fahrenheit() -> None:
    assert [unit_named(n, where="x") for n in ("kelvin", "°C", "DL")] == ["K", "C", "counts"]
    with pytest.raises(InputError, match="unknown unit"):
        unit_named("F", where="x")
