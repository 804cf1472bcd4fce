"""The measurement equation: limits, round trips, and the numbers that its page states."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging._band import Band
from thermo.imaging._optics import Optics
from thermo.imaging._planck import PlanckConstants
from thermo.imaging._radiometry import (
    apparent_temperature,
    measured_signal,
    temperature_from_signal,
    true_temperature,
)
from thermo.imaging._response import AbstractResponse, signal_of

PAGE = Path(__file__).parents[2] / "docs" / "radiometry.md"
LONG, MIDDLE = Band(7.5e-6, 14e-6), Band(3e-6, 5e-6)
COUNTS = PlanckConstants(21106.77, 0.012545258, 1501.0, 1.0, -7340.0)
WINDOW = Optics(
    0.6, 290.0, air_transmission=0.9, air_temperature=280.0, window_transmission=0.8,
    window_temperature=310.0, window_reflectance=0.15, window_reflected_temperature=305.0,
)  # fmt: skip

responses = st.sampled_from((LONG, MIDDLE, COUNTS))
kelvin = st.floats(200.0, 2000.0)
room = st.floats(220.0, 320.0)
emissivities = st.floats(0.05, 1.0)
transmissions = st.floats(0.3, 1.0)


@st.composite
def sights(draw: st.DrawFn) -> dict[str, float]:
    """Arguments of `Optics`: everything between an object and a camera."""
    passed = draw(transmissions)
    return {
        "emissivity": draw(emissivities),
        "reflected_temperature": draw(room),
        "air_transmission": draw(transmissions),
        "air_temperature": draw(room),
        "window_transmission": passed,
        "window_temperature": draw(room),
        "window_reflectance": draw(st.floats(0.0, 1.0)) * (1.0 - passed),
        "window_reflected_temperature": draw(room),
    }


def test_the_equation_by_hand() -> None:
    """The weights of the five sources, from the shares of `WINDOW`."""
    weights = [0.8 * 0.9 * 0.6, 0.8 * 0.9 * 0.4, 0.8 * 0.1, 0.05, 0.15]
    assert sum(weights) == pytest.approx(1.0)
    signals = signal_of(COUNTS, np.array([400.0, 290.0, 280.0, 310.0, 305.0]))
    assert measured_signal(COUNTS, WINDOW, 400.0) == pytest.approx(weights @ signals, rel=1e-13)


@given(responses, sights(), kelvin)
def test_true_and_apparent_are_inverse(
    response: AbstractResponse, sight: dict[str, float], temperature: float
) -> None:
    optics = Optics(**sight)
    apparent = apparent_temperature(response, optics, temperature)
    # In the middle band a dull object at 200 K is a thousandth of what comes from the room.
    close = 1e-8 if temperature < 300.0 else 1e-10
    assert true_temperature(response, optics, apparent) == pytest.approx(temperature, rel=close)
    signal = measured_signal(response, optics, temperature)
    found = temperature_from_signal(response, optics, signal)
    assert found == pytest.approx(temperature, rel=close)


@given(responses, kelvin)
def test_a_black_body_in_clear_air_is_read_right(
    response: AbstractResponse, temperature: float
) -> None:
    clear = Optics(1.0)
    assert apparent_temperature(response, clear, temperature) == pytest.approx(
        temperature, rel=1e-11
    )
    assert true_temperature(response, clear, temperature) == pytest.approx(temperature, rel=1e-11)


@given(responses, sights(), kelvin)
def test_where_all_is_as_warm_the_optics_do_not_matter(
    response: AbstractResponse, sight: dict[str, float], temperature: float
) -> None:
    """A closed room of one temperature is a black body, whatever is in it."""
    warm = {key: temperature if key.endswith("temperature") else sight[key] for key in sight}
    assert apparent_temperature(response, Optics(**warm), temperature) == pytest.approx(
        temperature, rel=1e-11
    )


@given(responses, sights(), kelvin, st.floats(0.01, 50.0))
def test_a_warmer_object_reads_warmer(
    response: AbstractResponse, sight: dict[str, float], temperature: float, more: float
) -> None:
    both = np.array([temperature, temperature + more])
    cool, warm = apparent_temperature(response, Optics(**sight), both)
    assert warm > cool


@given(responses, st.floats(0.05, 0.9), st.floats(0.01, 0.1), st.floats(330.0, 2000.0))
def test_a_brighter_surface_reads_warmer_above_the_room(
    response: AbstractResponse, emissivity: float, more: float, temperature: float
) -> None:
    dull = apparent_temperature(response, Optics(emissivity, 295.0), temperature)
    bright = apparent_temperature(response, Optics(emissivity + more, 295.0), temperature)
    assert 295.0 < dull < bright < temperature


def test_the_weights_of_what_was_left_out_are_nothing() -> None:
    stated = Optics(0.7, 295.0, air_temperature=280.0, window_temperature=310.0)
    assert measured_signal(LONG, Optics(0.7, 295.0), 350.0) == measured_signal(LONG, stated, 350.0)


def test_pixels_have_their_own_emissivity() -> None:
    emissivity = np.array([[0.2, 0.95], [1.0, np.nan]])
    temperature = np.array([[[350.0, 351.0], [352.0, 353.0]], [[300.0, 301.0], [302.0, 303.0]]])
    apparent = apparent_temperature(LONG, Optics(emissivity, 295.0), temperature)
    assert apparent.shape == (2, 2, 2)
    assert np.isnan(apparent[:, 1, 1]).all()
    alone = apparent_temperature(LONG, Optics(0.95, 295.0), 351.0)
    assert apparent[0, 0, 1] == pytest.approx(float(alone), rel=1e-14)
    back = true_temperature(LONG, Optics(emissivity, 295.0), apparent)
    np.testing.assert_allclose(back[:, 0], temperature[:, 0], rtol=1e-13)


def test_less_than_what_is_mirrored_has_no_temperature() -> None:
    metal = Optics(0.2, 295.0)
    mirrored = apparent_temperature(LONG, metal, 150.0)
    found = true_temperature(LONG, metal, np.array([float(mirrored) - 1.0, 250.0, 300.0]))
    assert np.isnan(found[1])
    assert found[2] > 300.0


@pytest.mark.parametrize("function", [apparent_temperature, true_temperature, measured_signal])
def test_readings_that_cannot_be_are_refused(function) -> None:
    with pytest.raises(InputError, match="Celsius"):
        function(LONG, Optics(0.9, 295.0), np.array([[25.0, 26.0]]))
    with pytest.raises(InputError, match="do not go together"):
        function(LONG, Optics(np.full((2, 3), 0.9), 295.0), np.full((3, 2), 300.0))


def test_signals_of_another_shape_are_refused() -> None:
    with pytest.raises(InputError, match="optics of shape \\(2, 3\\)"):
        temperature_from_signal(COUNTS, Optics(np.full((2, 3), 0.9), 295.0), np.ones(4))


def blocks() -> list[tuple[str, str]]:
    """Each block of Python in the page, and what the page says that it prints."""
    found = re.findall(
        r"```python\n(.*?)```\n.*?\n\n((?:    [^\n]*\n)+)", PAGE.read_text("utf-8"), re.S
    )
    return [(code, re.sub("^    ", "", output, flags=re.M)) for code, output in found]


def test_the_page_prints_what_it_says() -> None:
    assert len(blocks()) == 2
    names: dict[str, object] = {}
    for code, stated in blocks():
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, str(PAGE), "exec"), names)  # the page is ours
        assert printed.getvalue() == stated


def test_the_page_s_words_are_its_numbers() -> None:
    """What the text says of the table, and of another band."""
    _, table = blocks()[0]
    rows = [
        [float(one) for one in re.findall(r"-?\d+\.\d+", row)] for row in table.splitlines()[1:]
    ]
    assert [row[:3] for row in rows] == [
        [7.5, 14.0, 0.2],
        [7.5, 14.0, 0.3],
        [3, 5, 0.2],
        [3, 5, 0.3],
    ]
    text = " ".join(PAGE.read_text("utf-8").split())
    for row in (rows[0], rows[3]):
        assert f"{350 + row[6]:.0f} K to {350 + row[5]:.0f} K" in text
    assert all(-42.0 < row[4] < -29.0 for row in rows)
    assert "by 0.02 K at emissivity 0.95 and by 0.5 K at 0.2" in text
    for emissivity, shift in ((0.95, 0.02), (0.2, 0.5)):
        metal = Optics(emissivity, 295.0)
        read = apparent_temperature(LONG, metal, 350.0)
        assert float(true_temperature(Band(8e-6, 14e-6), metal, read)) - 350.0 == pytest.approx(
            shift, rel=0.25
        )
