"""Optics that cannot be are refused, with what was likely meant."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.imaging._optics import Optics


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"emissivity": 92.0}, "per cent"),
        ({"emissivity": 0.0}, "above 0"),
        ({"emissivity": -0.1}, "emissivity"),
        ({"emissivity": 1.0001}, "emissivity"),
        ({"emissivity": np.nan}, "emissivity"),
        ({"emissivity": np.array([0.5, 95.0])}, "per cent"),
        ({"emissivity": np.array([np.nan, 0.0])}, "above 0"),
        ({"emissivity": np.full((2, 2), np.nan)}, "nan"),
        ({"emissivity": "0.9"}, "plain numbers"),
        ({"reflected_temperature": 22.0}, "Celsius"),
        ({"reflected_temperature": np.array([295.0, np.nan])}, "reflected_temperature"),
        ({"reflected_temperature": None}, "missing"),
        ({"air_transmission": 98.0, "air_temperature": 295.0}, "per cent"),
        ({"air_transmission": 0.0, "air_temperature": 295.0}, "air_transmission"),
        ({"air_transmission": 0.98}, "air_temperature: a temperature is missing"),
        ({"air_transmission": 0.98, "air_temperature": 20.0}, "air_temperature"),
        ({"air_transmission": np.array([0.9, np.nan]), "air_temperature": 295.0}, "nan"),
        ({"window_transmission": 1.2}, "window_transmission"),
        ({"window_transmission": 0.9}, "window_temperature: a temperature is missing"),
        ({"window_reflectance": -0.1}, "window_reflectance"),
        ({"window_reflectance": 0.1}, "passes and mirrors more than it gets"),
        (
            {"window_transmission": 0.9, "window_reflectance": 0.1},
            "window_reflected_temperature: a temperature is missing",
        ),
        ({"emissivity": np.full(3, 0.5), "reflected_temperature": np.full(2, 295.0)}, "together"),
        ({"emissivity": np.full(3, 0.5), "air_transmission": np.ones(2)}, "together"),
    ],
)
def test_what_cannot_be_is_refused(given: dict[str, object], said: str) -> None:
    numbers = {"emissivity": 0.9, "reflected_temperature": 295.0} | given
    with pytest.raises(InputError, match=said) as refused:
        Optics(**numbers, where="scene.json")  # pyright: ignore
    assert "scene.json" in str(refused.value)
    assert "remedy" in str(refused.value)


def test_a_temperature_that_does_not_matter_may_be_left_out() -> None:
    optics = Optics(1.0)
    assert np.isnan(optics.reflected_temperature)
    assert optics.shape() == ()
    full = Optics(0.9, 295.0, window_transmission=0.9, window_reflectance=0.1,
                  window_reflected_temperature=300.0)  # fmt: skip
    assert np.isnan(full.window_temperature)


def test_an_emissivity_a_pixel_may_be_unknown_in_places() -> None:
    emissivity = np.array([[0.2, np.nan, 0.9], [0.2, 0.3, 1.0]])
    optics = Optics(emissivity, 295.0, air_transmission=np.full((2, 1), 0.99), air_temperature=290)
    assert optics.shape() == (2, 3)
    np.testing.assert_array_equal(optics.emissivity, emissivity)
