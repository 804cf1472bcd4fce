"""First-order uncertainty against finite differences, chance and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging._band import Band
from thermo.imaging._error_budget import Deviations, sensitivities, uncertainty
from thermo.imaging._optics import Optics
from thermo.imaging._planck import PlanckConstants
from thermo.imaging._radiometry import (
    apparent_temperature,
    measured_signal,
    temperature_from_signal,
    true_temperature,
)
from thermo.imaging._response import AbstractResponse, slope_of

LONG, MIDDLE = Band(7.5e-6, 14e-6), Band(3e-6, 5e-6)
COUNTS = PlanckConstants(21106.77, 0.012545258, 1501.0, 1.0, -7340.0)
STATED = {
    "emissivity": 0.6,
    "reflected_temperature": 290.0,
    "air_transmission": 0.9,
    "air_temperature": 280.0,
    "window_transmission": 0.8,
    "window_temperature": 310.0,
    "window_reflectance": 0.15,
    "window_reflected_temperature": 305.0,
}
WINDOW = Optics(**STATED)
responses = st.sampled_from((LONG, MIDDLE, COUNTS))


@given(responses, st.sampled_from(sorted(STATED)), st.floats(250.0, 1500.0))
def test_sensitivities_are_the_derivatives(
    response: AbstractResponse, name: str, temperature: float
) -> None:
    signal = measured_signal(response, WINDOW, temperature)
    step = 1e-6 * STATED[name]
    ends = [
        float(
            temperature_from_signal(
                response, Optics(**(STATED | {name: STATED[name] + off})), signal
            )
        )
        for off in (-step, step)
    ]
    slope = (ends[1] - ends[0]) / (2 * step)
    found = sensitivities(response, WINDOW, temperature)[name]
    assert found == pytest.approx(slope, rel=2e-4, abs=1e-5)


@settings(max_examples=15)
@given(responses, st.floats(250.0, 1500.0))
def test_sensitivities_to_the_reading(response: AbstractResponse, temperature: float) -> None:
    apparent = float(apparent_temperature(response, WINDOW, temperature))
    ends = true_temperature(response, WINDOW, np.array([apparent - 1e-3, apparent + 1e-3]))
    found = sensitivities(response, WINDOW, temperature)
    assert found["apparent"] == pytest.approx((ends[1] - ends[0]) / 2e-3, rel=1e-4)
    assert found["apparent"] / found["signal"] == pytest.approx(
        float(slope_of(response, apparent)), rel=1e-12
    )


def test_a_black_body_has_only_the_camera_s_noise() -> None:
    budget = uncertainty(LONG, Optics(1.0), 320.0, Deviations(apparent=0.05))
    assert budget.total() == pytest.approx(0.05, rel=1e-12)
    assert budget.in_common() == 0.0
    assert uncertainty(LONG, Optics(1.0), 320.0, Deviations()).total() == 0.0
    by_signal = Deviations(signal=0.05 * float(slope_of(LONG, 303.15)))
    noise = uncertainty(LONG, Optics(1.0), 303.15, by_signal).of_noise()
    assert noise == pytest.approx(0.05, rel=1e-12)


def test_wien_s_law_gives_the_closed_form() -> None:
    """S = exp(-B/T) with nothing mirrored: dT = T^2 / B * de / e."""
    wien = PlanckConstants(1.0, 1.0, 1500.0, 0.0, 0.0)
    dark = Optics(0.5, 150.0)
    found = uncertainty(wien, dark, 1000.0, Deviations(emissivity=0.01)).common["emissivity"]
    mirrored = 1.0 - np.exp(-1500.0 / 150.0 + 1500.0 / 1000.0)
    assert found == pytest.approx(1000.0**2 / 1500.0 * 0.02 * mirrored, rel=1e-12)


parts = st.floats(0.0, 0.5)


@settings(max_examples=8)
@given(parts, parts, parts, parts, st.floats(250.0, 900.0))
def test_parts_add_in_squares(
    noise: float, camera: float, around: float, air: float, temperature: float
) -> None:
    given_ = Deviations(
        apparent=noise, calibration=camera, reflected_temperature=around, air_temperature=air
    )
    budget = uncertainty(LONG, WINDOW, temperature, given_)
    alone = [
        float(uncertainty(LONG, WINDOW, temperature, one).total())
        for one in (
            Deviations(apparent=noise),
            Deviations(calibration=camera),
            Deviations(reflected_temperature=around),
            Deviations(air_temperature=air),
        )
    ]
    assert budget.total() == pytest.approx(np.sqrt(np.sum(np.square(alone))), rel=1e-12)
    assert budget.of_noise() == pytest.approx(alone[0], rel=1e-12)
    assert budget.in_common() == pytest.approx(np.sqrt(np.sum(np.square(alone[1:]))), rel=1e-12)


@pytest.mark.parametrize("response", [LONG, MIDDLE, COUNTS])
def test_it_is_what_chance_gives(response: AbstractResponse) -> None:
    known = Deviations(
        apparent=0.05, calibration=0.3, emissivity=0.005, reflected_temperature=0.5,
        air_transmission=0.004, air_temperature=1.0, window_transmission=0.003,
        window_temperature=0.7, window_reflectance=0.004, window_reflected_temperature=0.6,
    )  # fmt: skip
    generator = np.random.default_rng(3)
    drawn = Optics(**{
        name: value + getattr(known, name) * generator.normal(size=40_000)
        for name, value in STATED.items()
    })  # fmt: skip
    apparent = float(apparent_temperature(response, WINDOW, 400.0))
    read = apparent + np.hypot(0.05, 0.3) * generator.normal(size=40_000)
    budget = uncertainty(response, WINDOW, 400.0, known)
    spread = true_temperature(response, drawn, read).std()
    assert budget.total() == pytest.approx(spread, rel=0.02)


def test_the_largest_part_is_named_and_kept_a_pixel() -> None:
    metal = Optics(np.array([[0.2, 0.9], [0.3, np.nan]]), 295.0)
    known = Deviations(emissivity=0.05, apparent=0.1, reflected_temperature=0.5)
    budget = uncertainty(LONG, metal, np.full((2, 2), 350.0), known)
    assert budget.largest() == "emissivity"
    assert set(budget.noise) == {"signal", "apparent"}
    assert set(budget.noise) | set(budget.common) == set(vars(known))
    assert all(part.shape == (2, 2) for part in budget.common.values())
    assert np.isnan(budget.total()[1, 1])
    assert budget.total()[0, 0] > budget.total()[1, 0] > budget.total()[0, 1] > 0.1


@pytest.mark.parametrize(
    ("given_", "said"),
    [
        ({"emissivity": 5.0}, "per cent"),
        ({"apparent": -0.1}, "deviations: apparent"),
        ({"signal": np.nan}, "deviations: signal"),
        ({"window_reflectance": 2.0}, "not in per cent"),
    ],
)
def test_deviations_that_cannot_be_are_refused(given_: dict[str, float], said: str) -> None:
    with pytest.raises(InputError, match=said):
        Deviations(**given_)


def test_a_deviation_needs_the_temperature_of_its_source() -> None:
    with pytest.raises(InputError, match="deviations: air_transmission"):
        uncertainty(LONG, Optics(0.9, 295.0), 350.0, Deviations(air_transmission=0.01))
    near = Optics(0.9, 295.0, air_temperature=280.0)
    assert uncertainty(LONG, near, 350.0, Deviations(air_transmission=0.01)).total() > 0.1


def test_a_missing_temperature_has_no_uncertainty() -> None:
    budget = uncertainty(LONG, Optics(0.9, 295.0), np.full(3, np.nan), Deviations(emissivity=0.01))
    assert np.isnan(budget.total()).all()
