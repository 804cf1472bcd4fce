from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging._colours import COLOUR_MAPS, Colours, coloured, normalised


@given(low=st.floats(200.0, 400.0), span=st.floats(0.01, 500.0), value=st.floats(150.0, 1000.0))
def test_normalisation(low: float, span: float, value: float) -> None:
    share = normalised(np.array([value, low, low + span, np.nan]), low, low + span)
    assert share[0] == pytest.approx(min(max((value - low) / ((low + span) - low), 0.0), 1.0))
    assert share[1] == 0.0 and share[2] == pytest.approx(1.0) and np.isnan(share[3])


@pytest.mark.parametrize("name", COLOUR_MAPS)
def test_colours_are_those_of_the_map(name: str) -> None:
    picture = np.linspace(280.0, 320.0, 12).reshape(3, 4)
    picture[1, 2] = np.nan
    shown = coloured(picture, Colours(290.0, 310.0, name=name, background=(1, 2, 3)))
    wanted = mpl.colormaps[name](np.clip((picture - 290.0) / 20.0, 0, 1), bytes=True)[..., :3]
    wanted[1, 2] = [1, 2, 3]
    assert shown.dtype == np.uint8
    np.testing.assert_array_equal(shown, wanted)


def test_single_precision_shows_the_same() -> None:
    picture = np.random.default_rng(0).uniform(285.0, 315.0, (20, 30))
    colours = Colours(290.0, 310.0)
    double, single = coloured(picture, colours), coloured(picture.astype(np.float32), colours)
    assert (double != single).any(axis=-1).mean() < 0.01
    assert (coloured(picture, colours) == double).all() and not np.isnan(picture).any()


@pytest.mark.parametrize(
    ("arguments", "more", "message"),
    [
        ((300.0, 300.0), {}, "above 300"),
        ((300.0, np.nan), {}, "out of range"),
        ((290.0, 300.0), {"name": "rainbow"}, "inferno"),
        ((290.0, 300.0), {"background": (0, 0, 256)}, "no colour"),
    ],
)
def test_what_is_refused(arguments: tuple, more: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Colours(*arguments, **more)
