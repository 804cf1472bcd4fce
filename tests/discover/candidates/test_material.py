"""Properties that vary: none at strength zero, known laws and tensors, voids under a lamp."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lit_box import (
    FRAMES,
    NODES,
    OFF,
    SPACE,
    STATED,
    at,
    bare,
    change,
    hot,
    lit,
    nearest,
    one,
    order_of_remainder,
    solved,
)

from thermo.discover import Candidate, Place
from thermo.discover.candidates import (
    AnisotropicConductivity,
    TemperatureDependentConductivity,
    TemperatureDependentHeatCapacity,
    Void,
)
from thermo.discover.candidates._material import REFERENCE
from thermo.inverse import Conditions
from thermo.physics.effects import PolynomialLaw

MIDDLE = (0.013, 0.006, 0.003)  # m, below the lit spot
LIT, BELOW = nearest((0.013, 0.006, 0.008)), nearest((0.013, 0.006, 0.0))
BEGUN = (FRAMES > 4) & (FRAMES <= OFF)

MADE: dict[str, Callable[[float], Candidate]] = {
    "temperature_dependent_conductivity": lambda value: TemperatureDependentConductivity(
        one(value)
    ),
    "temperature_dependent_heat_capacity": lambda value: TemperatureDependentHeatCapacity(
        one(value)
    ),
    "anisotropic_conductivity": lambda value: AnisotropicConductivity(
        jnp.asarray([0.0, 0.0, value])
    ),
    "void": lambda value: Void(one(value), at(MIDDLE, 0.003)),
}


@pytest.mark.parametrize("under", [hot(), lit()], ids=["hot", "lit"])
@pytest.mark.parametrize("name", list(MADE))
def test_strength_zero_changes_nothing(name: str, under: Conditions) -> None:
    candidate = MADE[name](0.0)
    assert candidate.card.name == name
    assert np.abs(change(candidate, under)).max() < 1e-9


@pytest.mark.parametrize(
    ("name", "strength", "sign"),
    [
        # What conducts better where it is warm, or downwards, takes heat from the lit spot.
        ("temperature_dependent_conductivity", 5e-3, -1),
        ("temperature_dependent_conductivity", -5e-3, 1),
        ("temperature_dependent_heat_capacity", 5e-3, -1),
        ("temperature_dependent_heat_capacity", -5e-3, 1),
        ("anisotropic_conductivity", 0.5, -1),
        ("anisotropic_conductivity", -0.5, 1),
        ("void", 0.9, 1),
    ],
)
def test_the_lit_spot_warms_or_cools(name: str, strength: float, sign: int) -> None:
    moved = change(MADE[name](strength), lit())
    assert np.all(moved[0] == 0)
    assert np.all(sign * moved[BEGUN, LIT] > 0.05)


def test_heat_goes_further_along_an_axis_that_conducts_better() -> None:
    along_x = change(AnisotropicConductivity(jnp.asarray([1.0, 0.0, 0.0])), lit())
    along_z = change(MADE["anisotropic_conductivity"](1.0), lit())
    end = nearest((0.0, 0.006, 0.008))
    assert along_x[-1, end] > 0.05 and along_z[-1, BELOW] > 0.5
    assert along_x[-1, BELOW] < 0, "what goes sideways does not go down"


def test_a_void_shields_what_is_behind_it() -> None:
    assert np.all(change(MADE["void"](0.9), lit())[BEGUN, BELOW] < -0.05)


@given(st.floats(-0.05, 0.05), st.floats(250.0, 400.0))
def test_laws_are_straight_lines_through_one_at_the_reference(
    slope: float, level: float
) -> None:
    under = hot()
    conducts = TemperatureDependentConductivity(one(slope)).to_model(bare(under), under)
    stores = TemperatureDependentHeatCapacity(one(slope)).to_model(bare(under), under)
    assert conducts.capacity_law is None and stores.conductivity_law is None
    wanted = 1 + slope * (level - 293.15)
    for law in (conducts.conductivity_law, stores.capacity_law):
        assert isinstance(law, PolynomialLaw) and law.reference == REFERENCE == 293.15
        assert float(law.factor(jnp.asarray(level))) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize("name", ["conductivity", "heat_capacity"])
def test_laws_act_as_those_of_a_model(name: str) -> None:
    under = lit()
    law = PolynomialLaw(jnp.asarray([1.0, 4e-3]), 293.15)
    changes = {"conductivity_law": law} if name == "conductivity" else {"capacity_law": law}
    by_hand = replace(bare(under), **changes)
    made = MADE[f"temperature_dependent_{name}"](4e-3).to_model(bare(under), under)
    np.testing.assert_allclose(
        solved(made, under), solved(by_hand, under), rtol=0, atol=1e-9
    )


def test_one_strength_along_all_axes_is_a_conductivity() -> None:
    found = change(AnisotropicConductivity(jnp.full(3, 0.3)), lit())
    stated = replace(STATED, conductivity=1.3 * STATED.conductivity)
    wanted = solved(bare(lit(), stated), lit()) - solved(bare(lit()), lit())
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9)


def test_a_tensor_has_its_strengths_along_the_axes() -> None:
    made = AnisotropicConductivity(jnp.asarray([0.1, -0.2, 0.5])).to_model(bare(hot()), hot())
    wanted = STATED.conductivity * np.diag([1.1, 0.8, 1.5])
    np.testing.assert_allclose(made.conductivity, np.tile(wanted, (len(SPACE.mesh.cells), 1, 1)))


MIDDLES = NODES[SPACE.mesh.cells].mean(1)


@given(st.lists(st.floats(0.0, 3.0), min_size=2, max_size=2), st.floats(0.001, 0.1))
def test_voids_leave_a_little_conductivity(strengths: list[float], size: float) -> None:
    places = Place(jnp.asarray([MIDDLE, (0.004, 0.006, 0.004)]), jnp.asarray([size, 0.003]))
    model = Void(jnp.asarray(strengths), places).to_model(bare(hot()), hot())
    factor = np.asarray(model.conductivity) / STATED.conductivity
    assert factor.min() > 1e-4 * (1 - 1e-12) and factor.max() <= 1
    distance = ((MIDDLES[:, None] - np.asarray(places.centre)) ** 2).sum(-1)
    shape = np.exp(-distance / (2 * np.asarray(places.size) ** 2))
    np.testing.assert_allclose(factor, np.maximum(1 - shape @ strengths, 1e-4), atol=1e-12)


def test_a_void_in_a_body_whose_conductivity_is_a_tensor() -> None:
    under = hot()
    tensor = AnisotropicConductivity(jnp.asarray([0.0, 0.0, 1.0])).to_model(bare(under), under)
    both = MADE["void"](0.8).to_model(tensor, under)
    alone = MADE["void"](0.8).to_model(bare(under), under)
    ratio = np.asarray(both.conductivity) / np.asarray(alone.conductivity)[:, None, None]
    np.testing.assert_allclose(ratio, np.tile(np.diag([1.0, 1.0, 2.0]), (len(ratio), 1, 1)))


def test_the_derivative_by_the_strength_of_a_void_leaves_a_square() -> None:
    def make(strength: jax.Array) -> Candidate:
        return Void(strength, at(MIDDLE, 0.003))

    assert order_of_remainder(make, lit(), one(0.4), one(0.3)) > 1.9
