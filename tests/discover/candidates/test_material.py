"""Properties that vary: none at strength zero, known laws and tensors, voids under a lamp."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jaxtyping import Array
from lit_box import (
    DARK,
    FRAMES,
    NODES,
    OFF,
    SPACE,
    STATED,
    bare,
    change,
    hot,
    lit,
    nearest,
    one,
    run,
    solved,
    within,
)

from thermo.discover import AbstractHeatCandidate, Inclusion, Transition
from thermo.discover._candidate import FINE
from thermo.discover.candidates import (
    AnisotropicConductivity,
    LatentHeat,
    TemperatureDependentConductivity,
    TemperatureDependentHeatCapacity,
    Void,
)
from thermo.inverse import Conditions
from thermo.inverse._conditions import conditions, make_model
from thermo.inverse._properties import properties
from thermo.mesh import Mesh, box_mesh, cell_volumes
from thermo.observe import REFERENCE
from thermo.physics import discretise, stored_heat, volume_rule
from thermo.physics._balance import assemble, equivalent
from thermo.physics._quadrature import tetrahedron_rule
from thermo.physics.effects import PolynomialLaw, TabulatedLaw, TransitionLaw

MIDDLE = (0.013, 0.006, 0.003)  # m, below the lit spot
LIT, BELOW = nearest((0.013, 0.006, 0.008)), nearest((0.013, 0.006, 0.0))
DENSITY = 2700.0  # kg/m3
BEGUN = (FRAMES > 4) & (FRAMES <= OFF)


def latent(*values: float) -> LatentHeat:
    count = len(values)
    middle, width = (305.0, 320.0)[:count], (3.0, 2.0)[:count]
    place = Transition(jnp.asarray(middle), jnp.asarray(width))
    return LatentHeat(jnp.asarray(values), place, jnp.asarray(DENSITY))


MADE: dict[str, Callable[[float], AbstractHeatCandidate]] = {
    "temperature_dependent_conductivity": lambda value: TemperatureDependentConductivity(
        one(value)
    ),
    "temperature_dependent_heat_capacity": lambda value: TemperatureDependentHeatCapacity(
        one(value)
    ),
    "anisotropic_conductivity": lambda value: AnisotropicConductivity(
        jnp.asarray([0.0, 0.0, value])
    ),
    "latent_heat": lambda value: latent(value),
    "void": lambda value: Void(one(value), within(MIDDLE, 0.003)),
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
        ("latent_heat", 1e4, -1),
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
    assert np.all(along_x[BEGUN, end] > 0.05) and np.all(along_z[BEGUN, BELOW] > 0.2)
    assert np.all(along_x[BEGUN, BELOW] < 0), "what goes sideways does not go down"


def test_a_void_shields_what_is_behind_it() -> None:
    assert np.all(change(MADE["void"](0.9), lit())[BEGUN, BELOW] < -0.02)


@given(st.floats(-0.05, 0.05), st.floats(250.0, 400.0))
def test_laws_are_straight_lines_through_one_at_the_reference(slope: float, level: float) -> None:
    under = hot()
    conducts = TemperatureDependentConductivity(one(slope)).to_model(bare(under), under)
    stores = TemperatureDependentHeatCapacity(one(slope)).to_model(bare(under), under)
    assert conducts.capacity_law is None and stores.conductivity_law is None
    wanted = 1 + slope * (level - 293.15)
    for law in (conducts.conductivity_law, stores.capacity_law):
        assert isinstance(law, PolynomialLaw) and law.reference == REFERENCE == 293.15
        assert float(law.factor(jnp.asarray(level))) == pytest.approx(wanted, abs=1e-12)


@given(st.floats(0.0, 1e5), st.floats(0.0, 1e5))
def test_transitions_take_up_their_heats(first: float, second: float) -> None:
    under, body = hot(), bare(hot())
    law = latent(first, second).to_model(body, under).capacity_law
    assert isinstance(law, TransitionLaw)
    capacity = float(body.capacity[0])
    ends = law.integral(jnp.asarray([250.0, 312.5, 400.0]))
    # Between the two the first is over, to 2.5 of its widths.
    wanted = [
        62.5 + 0.9938 * first * DENSITY / capacity,
        150 + (first + second) * DENSITY / capacity,
    ]
    np.testing.assert_allclose(ends[1:] - ends[0], wanted, rtol=1e-3)
    at = jnp.linspace(290.0, 330.0, 7)
    slope = jax.vmap(jax.grad(law.integral))(at)
    np.testing.assert_allclose(slope, law.factor(at), rtol=1e-9)


@given(st.floats(-0.002, 0.05), st.floats(250.0, 400.0))
def test_a_slope_comes_on_top_of_what_is_stated(slope: float, level: float) -> None:
    under = hot()
    table = TabulatedLaw(jnp.asarray([280.0, 350.0]), jnp.asarray([0.9, 1.6]))
    stated = replace(bare(under), conductivity_law=table, capacity_law=table)
    conducts = TemperatureDependentConductivity(one(slope)).to_model(stated, under)
    stores = TemperatureDependentHeatCapacity(one(slope)).to_model(stated, under)
    assert conducts.capacity_law is table and stores.conductivity_law is table
    wanted = np.interp(level, [280.0, 350.0], [0.9, 1.6]) + slope * (level - REFERENCE)
    for law in (conducts.conductivity_law, stores.capacity_law):
        assert law is not None
        assert float(law.factor(jnp.asarray(level))) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize("tabulated", [False, True])
def test_a_transition_stands_beside_a_law(tabulated: bool) -> None:
    under = hot()
    body = bare(under)
    if tabulated:
        table = TabulatedLaw(jnp.asarray([280.0, 350.0]), jnp.asarray([0.9, 1.6]))
        body = replace(body, capacity_law=table)
    sloped = MADE["temperature_dependent_heat_capacity"](4e-3).to_model(body, under)
    law = latent(1e4).to_model(sloped, under).capacity_law
    assert law is not None and sloped.capacity_law is not None
    far = jnp.asarray([260.0, 400.0])
    np.testing.assert_allclose(law.factor(far), sloped.capacity_law.factor(far), rtol=1e-12)
    rises = [np.diff(np.asarray(one.integral(far)))[0] for one in (law, sloped.capacity_law)]
    capacity = float(bare(under).capacity[0])
    assert rises[0] - rises[1] == pytest.approx(1e4 * DENSITY / capacity, rel=1e-9)


def test_what_a_lamp_brings_is_stored_in_the_transition_as_well() -> None:
    under = lit()
    lossless = bare(under, replace(DARK, convection=0.0))
    # Wide, since the steps here warm the lit spot by several kelvin each.
    wide = replace(latent(2e4), place=Transition(jnp.asarray([305.0]), jnp.asarray([10.0])))
    model = wide.to_model(lossless, under)
    found, plain = solved(model, under), solved(lossless, under)
    balance = assemble(model)
    first, last = (
        float(stored_heat(balance, equivalent(balance, jnp.asarray(one))).sum())
        for one in (found[0], found[-1])
    )
    assert last - first == pytest.approx(1.2 * OFF, rel=1e-3)
    assert found[-1].mean() < plain[-1].mean() - 1.0, "a part of it makes nothing warmer"


@pytest.mark.parametrize("name", ["conductivity", "heat_capacity"])
def test_laws_act_as_those_of_a_model(name: str) -> None:
    under = lit()
    law = PolynomialLaw(jnp.asarray([1.0, 4e-3]), 293.15)
    changes = {"conductivity_law": law} if name == "conductivity" else {"capacity_law": law}
    by_hand = replace(bare(under, DARK), **changes)
    made = MADE[f"temperature_dependent_{name}"](4e-3).to_model(bare(under, DARK), under)
    np.testing.assert_allclose(solved(made, under), solved(by_hand, under), rtol=0, atol=1e-9)


def test_one_strength_along_all_axes_is_a_conductivity() -> None:
    found = change(AnisotropicConductivity(jnp.full(3, 0.3)), lit())
    stated = replace(STATED, conductivity=1.3 * STATED.conductivity)
    wanted = solved(bare(lit(), stated), lit()) - solved(bare(lit()), lit())
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9)


def test_a_tensor_has_its_strengths_along_the_axes() -> None:
    made = AnisotropicConductivity(jnp.asarray([0.1, -0.2, 0.5])).to_model(bare(hot()), hot())
    wanted = STATED.conductivity * np.diag([1.1, 0.8, 1.5])
    np.testing.assert_allclose(made.conductivity, np.tile(wanted, (len(SPACE.mesh.cells), 1, 1)))


@eqx.filter_jit
def weakened(candidate: Void) -> Array:
    """The conductivity of each cell with voids in the body [W/m/K]."""
    return candidate.to_model(bare(hot()), hot()).conductivity


def factor_of(candidate: Void) -> np.ndarray:
    """What is left of the conductivity along the edge in each cell [1]."""
    conductivity = weakened(candidate)
    return np.linalg.eigvalsh(np.asarray(conductivity))[:, -1] / STATED.conductivity


@given(
    st.lists(st.floats(0.0, 3.0), min_size=2, max_size=2),
    st.lists(st.floats(0.001, 0.1), min_size=3, max_size=3),
)
def test_voids_leave_a_little_conductivity(strengths: list[float], sizes: list[float]) -> None:
    centres = jnp.asarray([MIDDLE, (0.004, 0.006, 0.004)])
    two = jnp.ones(2)
    places = Inclusion(centres, jnp.asarray([sizes, [0.003] * 3]), 3 * two, 8 * two)
    factor = factor_of(Void(jnp.asarray(strengths), places))
    assert factor.min() > 1e-4 * (1 - 1e-12) and factor.max() <= 1 + 1e-12
    alone = factor_of(Void(jnp.asarray([strengths[0], 0.0]), places))
    assert np.all(factor <= alone + 1e-12)


@given(st.lists(st.floats(0.012, 0.1), min_size=3, max_size=3), st.floats(2.0, 12.0))
def test_a_void_is_a_superellipsoid_with_a_soft_edge(sizes: list[float], squareness: float) -> None:
    points, weights = tetrahedron_rule(12)
    corners = NODES[SPACE.mesh.cells]
    inside = np.einsum("pa,cax->cpx", points, corners)
    ways = np.abs(inside - np.array(MIDDLE)) / sizes
    radius = (ways**squareness).sum(-1) ** (1 / squareness)
    found = factor_of(Void(one(0.9), within(MIDDLE, sizes, squareness, 8.0)))
    np.testing.assert_allclose(found, 1 - 0.9 * np.exp(-(radius**8)) @ weights, atol=0.02)


@given(st.floats(2.0, 12.0), st.floats(4.0, 24.0), st.floats(0.1, 2.0))
def test_on_an_axis_only_the_sharpness_counts_and_on_a_diagonal_both(
    squareness: float, sharpness: float, way: float
) -> None:
    body = within((0.0, 0.0, 0.0), [0.001, 0.002, 0.003], squareness, sharpness)
    along = jnp.asarray([[0.0, 0.002 * way, 0.0], [0.001 * way, 0.002 * way, 0.003 * way]])
    radius = way * np.array([1.0, 3 ** (1 / squareness)])
    np.testing.assert_allclose(body.shapes(along)[0], np.exp(-(radius**sharpness)), atol=1e-6)


@jax.jit
def share_of_form(form: Array, there: Array) -> Array:
    """Of a void at a point, by squareness, sharpness and factors on its half-widths."""
    place = replace(within(MIDDLE, 0.004), squareness=form[:1], sharpness=form[1:2])
    return replace(place, size=place.size * form[2:]).shapes(there)[0, 0]


slope_of_form = jax.jit(jax.grad(share_of_form))


@given(
    # About its edge, and a body away.
    st.lists(st.floats(-0.005, 0.005), min_size=3, max_size=3)
    | st.lists(st.floats(-0.05, 0.05), min_size=3, max_size=3),
    st.floats(2.0, 12.0),
    st.floats(4.0, 24.0),
)
def test_the_form_of_a_void_has_slopes_everywhere(
    way: list[float], squareness: float, sharpness: float
) -> None:
    there = jnp.asarray(way)[None] + jnp.asarray(MIDDLE)
    form = np.array([squareness, sharpness, 1.0, 1.0, 1.0])
    slopes = np.asarray(slope_of_form(jnp.asarray(form), there))
    assert np.isfinite(slopes).all()
    small = 1e-6
    for slope, way in zip(slopes, np.eye(len(form)), strict=True):
        ahead, behind = (
            share_of_form(jnp.asarray(form + sign * small * way), there) for sign in (1, -1)
        )
        assert float(ahead - behind) / 2 / small == pytest.approx(float(slope), abs=1e-4)


def test_a_small_void_weakens_what_it_fills_and_nothing_else() -> None:
    factor = factor_of(Void(one(0.9), within(MIDDLE, 0.004)))
    assert factor.min() < 0.5 and factor.max() > 0.999


def test_in_the_middle_of_a_void_the_form_has_no_slope() -> None:
    centre = jnp.asarray(MIDDLE)[None]
    slopes = jax.grad(lambda place: place.shapes(centre)[0, 0])(within(MIDDLE, 0.004))
    assert all(float(jnp.abs(leaf).max()) < 1e-9 for leaf in jax.tree.leaves(slopes))


@pytest.mark.parametrize("first", [AnisotropicConductivity, Void])
def test_a_cell_that_an_edge_cuts_conducts_as_layers_do(first: type) -> None:
    # Far wider than the body, so that its edge is flat; it cuts cells.
    flat = Void(one(0.8), within((0.0, 0.0, 0.0), [10.0, 10.0, 0.003], 12.0, 24.0))
    double = AnisotropicConductivity(jnp.asarray([0.0, 0.0, 1.0]))
    under, model = hot(), bare(hot())
    for candidate in (flat, double) if first is Void else (double, flat):
        model = candidate.to_model(model, under)
    tensor = np.asarray(model.conductivity) / STATED.conductivity
    rule = volume_rule(SPACE, FINE)
    share = np.asarray(rule.weight / rule.weight.sum(0))
    factor = 1 - 0.8 * np.asarray(flat.place.shapes(rule.at))[0]
    along, across = (share * factor).sum(0), 1 / (share / factor).sum(0)
    assert np.any(across < 0.7 * along)
    wanted = np.stack([along, along, 2 * across], 1)
    np.testing.assert_allclose(tensor, wanted[:, :, None] * np.eye(3), atol=1e-9)


@pytest.mark.parametrize("strengths", [(0.0, 0.0), (0.9, 0.0), (0.9, 0.5)])
def test_slopes_are_finite_where_a_void_is_about_the_middle_of_a_cell(
    strengths: tuple[float, float],
) -> None:
    centres = NODES[SPACE.mesh.cells[:2, :4]].mean(1)
    ones, under = jnp.ones(2), hot()
    place = Inclusion(jnp.asarray(centres), jnp.full((2, 3), 1e-3), 12 * ones, 24 * ones)
    whole = (jnp.asarray(strengths), place)

    @jax.jit
    def conductivity(parts: tuple[Array, Inclusion]) -> Array:
        return Void(*parts).to_model(bare(under), under).conductivity

    for way in (jax.tree.map(jnp.ones_like, whole), jax.tree.map(jnp.zeros_like, whole)):
        value, slope = jax.jvp(conductivity, (whole,), (way,))
        assert bool(jnp.isfinite(value).all() and jnp.isfinite(slope).all())


@pytest.mark.parametrize(("cells", "off"), [(12, 0.08), (24, 0.02)])
def test_a_crack_holds_back_what_it_should(cells: int, off: float) -> None:
    """Between a warm and a cold end lengths over conductivities add up."""
    height, thin, strength = 0.008, 0.001, 0.95  # m, m, 1
    space = discretise(box_mesh((0.004, 0.004, height), (2, 2, cells)))
    body = properties(STATED, {}, len(space.mesh.cells), len(space.mesh.faces))
    under = conditions(run(points=np.array([[0.002, 0.002, height]])), space)
    crack = Void(one(strength), within((0.002, 0.002, 0.0045), [10.0, 10.0, thin / 2], 12.0, 24.0))
    made = eqx.filter_jit(lambda one: one.to_model(make_model(space, body, under), under))
    model = made(crack)
    along = jnp.stack([jnp.zeros(4001), jnp.zeros(4001), jnp.linspace(0, height, 4001)], 1)
    wanted = float(jnp.mean(1 / (1 - strength * crack.place.shapes(along)[0])))
    tensor = np.asarray(model.conductivity) / STATED.conductivity
    plain = np.linalg.eigvalsh(tensor)[:, -1][:, None, None] * np.eye(3)
    errors = [abs(resistance(space.mesh, one) / wanted - 1) for one in (tensor, plain)]
    assert errors[0] < off and errors[0] < 0.4 * errors[1]


def resistance(mesh: Mesh, conductivity: np.ndarray) -> float:
    """From bottom to top, over that of a box that conducts all over as 1 does [1]."""
    nodes = np.asarray(mesh.nodes)
    matrix, level = stiffness(mesh, conductivity), nodes[:, 2] / nodes[:, 2].max()
    inner = (level > 1e-9) & (level < 1 - 1e-9)
    level[inner] = np.linalg.solve(matrix[np.ix_(inner, inner)], -matrix[inner] @ (level * ~inner))
    return float(np.prod(nodes.max(0)) / nodes[:, 2].max() ** 2 / (level @ matrix @ level))


def stiffness(mesh: Mesh, conductivity: np.ndarray) -> np.ndarray:
    """Of linear tetrahedra [W/K]."""
    corners = np.asarray(mesh.nodes)[mesh.cells]
    slopes = np.linalg.inv(corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1)
    slopes = np.concatenate([-slopes.sum(1, keepdims=True), slopes], 1)
    each = np.einsum("cax,cxy,cby,c->cab", slopes, conductivity, slopes, cell_volumes(mesh))
    matrix = np.zeros((len(mesh.nodes),) * 2)
    np.add.at(matrix, (mesh.cells[:, :, None], mesh.cells[:, None, :]), each)
    return matrix


@given(
    st.floats(2.0, 12.0),
    st.lists(st.floats(0.001, 0.1), min_size=3, max_size=3),
)
def test_the_edge_of_a_void_is_where_a_share_of_1_over_e_is_left(
    squareness: float, sizes: list[float]
) -> None:
    body = within(MIDDLE, sizes, squareness, 8.0)
    edge = body.edge(0)
    np.testing.assert_allclose(body.shapes(jnp.asarray(edge))[0], np.exp(-1), rtol=1e-6)
    # All around: no direction from the middle is far from all that are looked at.
    ways = (edge - np.array(MIDDLE)) / sizes
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    asked = np.concatenate([np.eye(3), -np.eye(3), np.full((1, 3), 3**-0.5)])
    assert (asked @ ways.T).max(axis=1).min() > np.cos(0.1)
