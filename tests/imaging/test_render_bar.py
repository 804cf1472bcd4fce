from __future__ import annotations

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.imaging._colours import Colours
from thermo.imaging._render_bar import Degrees, _round_numbers, _texts, colour_bar, with_bar

COLOURS = Colours(285.3, 316.2)


def test_the_bar_goes_from_hot_above_to_cold_below() -> None:
    bar = colour_bar(240, COLOURS)
    is_table = (bar[:, :, None] == COLOURS.table).all(-1).any(-1)
    column = int(np.argmax(is_table.sum(axis=0)))
    strip = bar[np.flatnonzero(is_table[:, column]), column].astype(int)
    assert len(strip) > 150
    assert np.abs(strip[0] - COLOURS.table[-1]).max() < 8
    assert np.abs(strip[-1] - COLOURS.table[0]).max() < 8
    assert (np.diff(strip.sum(axis=1)) <= 0).mean() > 0.95  # inferno grows lighter with heat


def test_the_bar_stands_beside_the_picture() -> None:
    picture = np.zeros((120, 50, 3), np.uint8)
    both = with_bar(picture, COLOURS, Degrees.CELSIUS)
    np.testing.assert_array_equal(both[:, :50], picture)
    np.testing.assert_array_equal(both[:, 50:], colour_bar(120, COLOURS, Degrees.CELSIUS))
    # Ink upon the white to the right of the strip.
    assert (both[:, -8:].min() < 120) or (both[:, -20:].min() < 120)


def test_numbers_differ_between_kelvin_and_celsius() -> None:
    kelvin, celsius = colour_bar(240, COLOURS), colour_bar(240, COLOURS, Degrees.CELSIUS)
    assert kelvin.shape != celsius.shape or (kelvin != celsius).any()


@pytest.mark.parametrize(
    ("low", "high"), [(285.3, 316.2), (12.15, 12.19), (300.0, 1300.0), (0, 1e-3)]
)
def test_marks_are_round_and_inside(low: float, high: float) -> None:
    marks = _round_numbers(low, high, 6)
    assert 2 <= len(marks) <= 12
    assert min(marks) >= low - 1e-9 and max(marks) <= high + 1e-9
    step = np.diff(marks)
    np.testing.assert_allclose(step, step[0])
    leading = step[0] / 10.0 ** np.floor(np.log10(step[0]) + 1e-9)
    assert min(abs(leading - one) for one in (1, 2, 2.5, 5)) < 1e-6
    texts = _texts(marks)
    assert len(set(texts)) == len(texts)
    np.testing.assert_allclose([float(one) for one in texts], marks, atol=1e-3 * step[0])


def test_a_dark_background_gets_light_numbers() -> None:
    bar = colour_bar(120, Colours(290.0, 300.0, background=(0, 0, 0)))
    assert (bar[:, -12:].max()) > 200


def test_small_pictures_have_no_room() -> None:
    with pytest.raises(InputError, match="at least 48 rows"):
        colour_bar(40, COLOURS)
