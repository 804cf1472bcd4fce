"""The scheme of a fit: two iterations a stage where what is stated follows the temperature."""

from __future__ import annotations

from dataclasses import replace

import pytest

from thermo.inverse import law_of
from thermo.inverse._properties import Stated
from thermo.inverse._stepping import scheme_for
from thermo.observe import TemperatureTable
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
