"""The scheme of a fit, and how far heat goes in its steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from thermo.inverse import law_of
from thermo.inverse._properties import Stated
from thermo.inverse._stepping import longest_reach, scheme_for
from thermo.observe import TemperatureTable
from thermo.physics import uniform_steps
from thermo.physics.integrators import BackwardEuler, Sdirk2

PLAIN = Stated(0.5, 1.5e6, 10.0, 0.9)
LAW = law_of(TemperatureTable((280.0, 340.0), (1000.0, 1600.0)))


@pytest.mark.parametrize("scheme", [BackwardEuler(), Sdirk2()])
@pytest.mark.parametrize("name", ["conductivity_law", "capacity_law"])
def test_a_table_wants_two_iterations(scheme: BackwardEuler | Sdirk2, name: str) -> None:
    found = scheme_for(scheme, replace(PLAIN, **{name: LAW}))
    assert type(found) is type(scheme) and found == replace(scheme, iterations=2)
    assert scheme_for(scheme, PLAIN) is scheme
    more = replace(scheme, iterations=3)
    assert scheme_for(more, replace(PLAIN, **{name: LAW})) is more


def test_the_longest_step_of_all_runs_says_how_far_heat_goes() -> None:
    grids = [uniform_steps(np.array([0.0, 1.0, 2.0]), size) for size in (0.5, 1.0, 0.25)]
    assert longest_reach(BackwardEuler(), grids, 1e-6) == pytest.approx(1e-6, rel=1e-12)
    assert longest_reach(Sdirk2(), grids[:1], 1e-6) == pytest.approx((1 - 0.5**0.5) * 5e-7)
