"""Tables of a property: what they say, and what is refused."""

from __future__ import annotations

import pytest

from thermo.errors import InputError
from thermo.observe import StatedMaterial, TemperatureTable


def test_it_is_linear_in_between_and_constant_outside() -> None:
    table = TemperatureTable((300, 400), (1000, 1500))
    assert table == TemperatureTable((300.0, 400.0), (1000.0, 1500.0))
    assert [table.at(one) for one in (200.0, 300.0, 320.0, 900.0)] == [1000, 1000, 1100, 1500]
    assert table.at() == 1000.0


def test_a_material_has_the_values_at_the_reference() -> None:
    capacity = TemperatureTable((283.15, 303.15), (900.0, 1100.0))
    conductivity = TemperatureTable((273.15, 313.15), (0.1, 0.3))
    material = StatedMaterial("clay", 2000.0, capacity, conductivity)
    assert material.volumetric_heat_capacity() == pytest.approx(2e6)
    assert material.first_conductivity() == pytest.approx(0.2)
    plain = StatedMaterial("clay", 2000.0, 1000.0, None)
    assert plain.volumetric_heat_capacity() == 2e6 and plain.first_conductivity() is None


@pytest.mark.parametrize(
    ("temperature", "value", "told"),
    [
        ((20.0, 400.0), (1.0, 2.0), "degrees Celsius, add 273.15"),
        ((300.0,), (1.0,), "two or more"),
        ((400.0, 300.0), (1.0, 2.0), "sort the table"),
        ((300.0, float("nan")), (1.0, 2.0), "a finite number"),
        ((300.0, 400.0), (1.0, 2.0, 3.0), "as many values as temperatures"),
        ((300.0, 400.0), (1.0, 0.0), "0 at 400 K"),
        ((300.0, 400.0), (float("nan"), 1.0), "nan at 300 K"),
        ((300.0, 400.0), (1.0, float("inf")), "finite and above 0"),
    ],
)
def test_what_cannot_be_is_refused(
    temperature: tuple[float, ...], value: tuple[float, ...], told: str
) -> None:
    with pytest.raises(InputError) as fault:
        TemperatureTable(temperature, value, where="scene.json: material.heat_capacity")
    assert told in str(fault.value) and "scene.json: material.heat_capacity." in str(fault.value)
