"""Stated values and fields turned into the properties of a body; unknowns that clash."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.fields import QUANTITIES
from thermo.inverse import Uniform
from thermo.inverse._properties import (
    Stated,
    check_unknowns,
    diffusivity_quantile,
    properties,
)
from thermo.observe import Scene

from .objectives import MESH

STATED = Stated(conductivity=0.8, capacity=1.54e6, convection=25.0, emissivity=0.6)
CLASHES = {
    frozenset(pair)
    for pair in (
        ("conductivity", "diffusivity"),
        ("convection", "scaled_convection"),
        ("emissivity", "scaled_emissivity"),
    )
}
PLACE = {
    "conductivity": "conductivity",
    "diffusivity": "conductivity",
    "volumetric_heat_capacity": "capacity",
    "convection": "convection",
    "scaled_convection": "convection",
    "emissivity": "emissivity",
    "scaled_emissivity": "emissivity",
}


def made(**values: float) -> dict[str, np.ndarray]:
    """The one value of each property [SI], with uniform fields of the given values."""
    fields = {
        name: Uniform().make(QUANTITIES[name], MESH, value, 0)[0] for name, value in values.items()
    }
    both = {name: (field.cell_values(), field.face_values()) for name, field in fields.items()}
    body = properties(STATED, both, len(MESH.cells), len(MESH.faces))
    lengths = {"conductivity": "cells", "capacity": "cells"}
    found = {}
    for name in ("conductivity", "capacity", "convection", "emissivity"):
        array = np.asarray(getattr(body, name))
        assert array.shape == (len(getattr(MESH, lengths.get(name, "faces"))),)
        assert np.ptp(array) <= 1e-12 * array[0]
        found[name] = array[0]
    return found


def test_without_fields_everything_is_as_stated() -> None:
    assert made() == {
        "conductivity": 0.8, "capacity": 1.54e6, "convection": 25.0, "emissivity": 0.6
    }  # fmt: skip


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        ({"conductivity": 1.7}, {"conductivity": 1.7}),
        ({"diffusivity": 1e-6}, {"conductivity": 1.54}),
        # The paper's alpha, beta, gamma: k / rho c, h / rho c, eps / rho c.
        ({"scaled_convection": 2e-5}, {"convection": 30.8}),
        ({"scaled_emissivity": 5e-7}, {"emissivity": 0.77}),
        ({"convection": 12.0, "emissivity": 0.3}, {"convection": 12.0, "emissivity": 0.3}),
        ({"volumetric_heat_capacity": 2e6}, {"capacity": 2e6}),
        # Diffusivity keeps its meaning at the capacity in force.
        (
            {"diffusivity": 1e-6, "volumetric_heat_capacity": 2e6},
            {"conductivity": 2.0, "capacity": 2e6},
        ),
    ],
)
def test_fields_stand_in_for_stated_values(
    given: dict[str, float], wanted: dict[str, float]
) -> None:
    assert made(**given) == pytest.approx({**made(), **wanted}, rel=1e-9)


@pytest.mark.parametrize("name", list(QUANTITIES))
def test_a_field_at_the_stated_value_changes_nothing(name: str) -> None:
    assert made(**{name: STATED.of(name)}) == pytest.approx(made(), rel=1e-9)


@pytest.mark.parametrize("name", list(QUANTITIES))
def test_each_quantity_moves_one_property_in_proportion(name: str) -> None:
    found = made(**{name: 1.5 * STATED.of(name)})
    assert found == pytest.approx({**made(), PLACE[name]: 1.5 * made()[PLACE[name]]}, rel=1e-9)


@pytest.mark.parametrize("pair", list(combinations(QUANTITIES, 2)))
def test_two_names_of_one_property_are_refused_and_others_are_not(
    pair: tuple[str, str], scene: Scene
) -> None:
    if frozenset(pair) not in CLASHES:
        check_unknowns(pair, scene)
        return
    with pytest.raises(InputError, match="two unknowns describe the same property") as caught:
        check_unknowns(pair, scene)
    assert caught.value.value == ", ".join(pair)
    assert pair[0] in caught.value.remedy and pair[1] in caught.value.remedy


@pytest.mark.parametrize("name", ["conductivity", "convection", "emissivity"])
def test_a_property_that_nobody_states_must_be_unknown(name: str, scene: Scene) -> None:
    if name == "conductivity":
        without = replace(scene, material=replace(scene.material, conductivity=None))
    else:
        without = replace(scene, unknown=(name,), **{name: None})
    with pytest.raises(InputError, match=f"{name} is neither stated nor unknown") as caught:
        check_unknowns(("volumetric_heat_capacity",), without)
    assert caught.value.where == f"{scene.folder}/scene.json: {name}"
    assert "unknown=" in caught.value.remedy
    other = {"conductivity": "diffusivity"}.get(name, f"scaled_{name}")
    check_unknowns((name,), without)
    check_unknowns((other,), without)


def test_the_diffusivity_of_a_body_is_that_of_its_cells() -> None:
    cells, faces = len(MESH.cells), len(MESH.faces)
    least = np.linspace(1.0, 3.0, cells)
    values = {"conductivity": (2 * least, np.ones(faces))}
    values["volumetric_heat_capacity"] = (1e6 * least[::-1], np.ones(faces))
    expected = np.quantile(2e-6 * least / least[::-1], [0.05, 0.5])
    found = [diffusivity_quantile(STATED, values, cells, share) for share in (0.05, 0.5)]
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    exchange = {"convection": (np.zeros(cells), np.full(7, 9.0))}
    found = diffusivity_quantile(STATED, {**values, **exchange}, cells, 0.5)
    assert found == pytest.approx(expected[1], rel=1e-12)
    stated = STATED.of("diffusivity")
    assert diffusivity_quantile(STATED, {}, cells, 0.3) == pytest.approx(stated, rel=1e-12)
