"""How steep a law may be, against temperatures and tables that are known."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lit_box import FRAMES, POINTS, run

from thermo.discover._slope_limits import LEFT, slope_limits
from thermo.observe import REFERENCE, Recording, Run
from thermo.physics.effects import TabulatedLaw


def reading(*temperatures: float, initial: float = REFERENCE) -> Run:
    """A run that begins at one temperature and whose samples read others, one of them nothing."""
    values = np.full((len(FRAMES), len(POINTS)), temperatures[0])
    values[1 : 1 + len(temperatures), 0] = temperatures
    values[0, 1] = np.nan
    return replace(run(initial=initial), recording=Recording(POINTS, FRAMES, values))


@given(st.floats(250.0, 292.0), st.floats(295.0, 900.0))
def test_a_tenth_is_left_at_the_coldest_and_at_the_hottest(cold: float, hot: float) -> None:
    least, most = slope_limits(None, [reading(300.0 if hot > 300 else hot, hot), reading(cold)])
    assert 1 + least * (hot - REFERENCE) == pytest.approx(LEFT)
    assert 1 + most * (cold - REFERENCE) == pytest.approx(LEFT)


def test_what_is_only_warmer_bounds_one_way() -> None:
    least, most = slope_limits(None, [reading(353.15, initial=313.15)])
    assert least == pytest.approx(-0.9 / 60) and most == np.inf
    assert slope_limits(None, [reading(REFERENCE)]) == (-np.inf, np.inf)


def test_a_table_that_grows_may_be_cut_by_more() -> None:
    law = TabulatedLaw(jnp.array([REFERENCE, 393.15]), jnp.array([1.0, 3.0]))
    least, _ = slope_limits(law, [reading(393.15)])
    assert least == pytest.approx(-0.9 * 3.0 / 100)
