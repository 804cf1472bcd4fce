"""Recordings of counts and of apparent temperatures brought to true ones."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.imaging import Frames
from thermo.imaging._band import Band
from thermo.imaging._optics import Optics
from thermo.imaging._planck import PlanckConstants
from thermo.imaging._radiometry import apparent_temperature, measured_signal
from thermo.imaging._true_frames import to_temperature

LONG = Band(7.5e-6, 14e-6)
COUNTS = PlanckConstants(21106.77, 0.012545258, 1501.0, 1.0, -7340.0)
METAL = Optics(0.3, 295.0, air_transmission=0.98, air_temperature=293.0)
TRUE = 300.0 + np.arange(24.0).reshape(2, 3, 4)


def test_apparent_temperatures_become_true() -> None:
    read = Frames([0.0, 0.5], apparent_temperature(LONG, METAL, TRUE))
    frames = to_temperature(read, LONG, METAL)
    np.testing.assert_allclose(frames.values, TRUE, atol=5e-4)  # float32, over a third
    assert frames.valid.all() and not frames.counts
    np.testing.assert_array_equal(frames.time, [0.0, 0.5])


def test_counts_become_true() -> None:
    read = Frames([0.0, 0.5], measured_signal(COUNTS, METAL, TRUE), counts=True)
    frames = to_temperature(read, COUNTS, METAL)
    np.testing.assert_allclose(frames.values, TRUE, atol=5e-3)
    assert not frames.counts


def test_pixels_without_a_temperature_are_not_valid() -> None:
    values = apparent_temperature(LONG, METAL, TRUE)
    values[0, 0, 0], values[1, 2, 3] = 200.0, np.nan
    valid = np.ones((3, 4), bool)
    valid[1, 1] = False
    frames = to_temperature(Frames([0.0, 0.5], values, valid), LONG, METAL)
    expected = np.ones((2, 3, 4), bool)
    expected[0, 0, 0] = expected[1, 2, 3] = False
    expected[:, 1, 1] = False
    np.testing.assert_array_equal(frames.valid, expected)
    assert np.isnan(frames.values[0, 0, 0])


def test_an_emissivity_that_is_known_on_the_object_alone() -> None:
    emissivity = np.full((3, 4), np.nan)
    emissivity[1, 1:3] = 0.3
    metal = Optics(emissivity, 295.0)
    read = apparent_temperature(LONG, Optics(0.3, 295.0), TRUE)
    frames = to_temperature(Frames([0.0, 0.5], read), LONG, metal)
    np.testing.assert_array_equal(frames.valid, np.broadcast_to(np.isfinite(emissivity), (2, 3, 4)))
    np.testing.assert_allclose(frames.values[:, 1, 1:3], TRUE[:, 1, 1:3], atol=5e-4)


def test_hopeless_readings_are_refused() -> None:
    cold = Frames([0.0, 0.5], np.full((2, 3, 4), 270.0))
    with pytest.raises(InputError, match="24 of 24 valid values have none; the median reads 270 K"):
        to_temperature(cold, LONG, METAL, where="run.npz")
    bright = Frames([0.0], np.full((1, 3, 4), 4e9), counts=True)
    with pytest.raises(InputError, match="run.npz: most of these counts have no temperature"):
        to_temperature(bright, LONG, METAL, where="run.npz")
    with pytest.raises(InputError, match="calibration of this very camera"):
        to_temperature(Frames([0.0], np.zeros((1, 3, 4)), counts=True), COUNTS, METAL)


def test_half_may_be_lost() -> None:
    values = np.full((1, 1, 4), 300.0)
    values[0, 0, :2] = 200.0
    assert to_temperature(Frames([0.0], values), LONG, METAL).valid.sum() == 2
    values[0, 0, 2] = 200.0
    with pytest.raises(InputError, match="3 of 4"):
        to_temperature(Frames([0.0], values), LONG, METAL)


@pytest.mark.parametrize("shape", [(4, 3), (2, 3, 4), (5,)])
def test_optics_of_other_pixels_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match="optics and frames differ in shape"):
        to_temperature(Frames([0.0, 1.0], TRUE), LONG, Optics(np.full(shape, 0.9), 295.0))
