"""The unknowns before and after, and in which intervals they are."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from standings import VALUES, standing

from thermo.discover import _parameters
from thermo.discover._bench import Bench
from thermo.discover._descent import Ended, Free
from thermo.discover._extended import Extended, moved, numbers
from thermo.discover._parameters import parameter_intervals, parameters
from thermo.discover._standing import Standing
from thermo.discover.candidates import SensorLag
from thermo.inverse import start

from .lit_objective import objective

SCALE = 0.3


def at(logarithm: float, slopes: np.ndarray, smooth: float) -> Standing:
    """A standing with one conductivity, so far above the first one, and a lag at work [1]."""
    made = objective(controls=1)
    first = Extended(start(made), (SensorLag(jnp.ones(1)),))
    change = np.zeros(numbers(first).count)
    change[0] = logarithm
    here = standing(60.0, 2, smooth)
    bench = object.__new__(Bench)
    object.__setattr__(bench, "coarse", made)
    point = moved(first, change)
    return replace(here, bench=bench, point=point, ended=Ended(point, here.ended.residual, slopes))


def test_values_are_those_before_and_after() -> None:
    before, after = (at(one, np.zeros((VALUES, 2)), 1.0) for one in (0.0, 0.5))
    ((name, (one, other)),) = parameters(before, after).items()
    assert name == "conductivity" and other / one == pytest.approx(np.exp(0.5), rel=1e-2)


@pytest.mark.parametrize(("smooth", "wider"), [(0.5, 1.0), (9.0, 3.0)])
def test_ends_are_so_many_deviations_away_beside_all_that_was_fitted(
    monkeypatch: pytest.MonkeyPatch, smooth: float, wider: float
) -> None:
    # Two columns that are alike by 0.6: errors are 1 / 0.8 times those of one alone.
    slopes = np.zeros((VALUES, 2))
    slopes[0], slopes[1, 1] = (20.0, 20.0 * 0.6), 20.0 * 0.8
    wide = np.full(2, np.inf)
    free = Free(np.arange(2), np.array([SCALE, 1.0]), -wide, wide, np.array([True, False]))
    monkeypatch.setattr(_parameters, "free_of", lambda _: free)
    here = at(0.0, slopes, smooth)
    ((low, high),) = parameter_intervals(here).values()
    ((value, _),) = parameters(here, here).values()
    apart = 1.96 * SCALE * wider / (20.0 * 0.8)
    np.testing.assert_allclose([low / value, high / value], np.exp([-apart, apart]), rtol=2e-3)
