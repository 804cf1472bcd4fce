"""Effects of the surroundings: none at strength zero, the right sign, known cases."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from lit_box import (
    AIR,
    FRAMES,
    HOT,
    SIZE,
    SPACE,
    STATED,
    at,
    bare,
    change,
    hot,
    lit,
    nearest,
    one,
    resting,
    solved,
    wrapped,
)

from thermo.discover import Candidate, Inclusion, Place
from thermo.discover.candidates import (
    AmbientDrift,
    BackingConduction,
    Evaporation,
    LocalConvection,
    MissingRadiation,
    SupportContact,
)
from thermo.discover.candidates._surroundings import BackingFlow, Vapour, saturation
from thermo.inverse import Conditions
from thermo.mesh import box_mesh
from thermo.physics import Discretisation, Model, discretise
from thermo.physics.effects import Contact, Convection, History, Radiation

TOP = (0.006, 0.006, 0.008)  # m
END = float(FRAMES[-1])
SIDES = ("-x", "-y", "-z", "+x", "+y", "+z")


def on_side(number: int, value: float) -> jax.Array:
    return jnp.zeros(6).at[number].set(value)


def supported(strength: jax.Array, depth: float = 0.001) -> SupportContact:
    return SupportContact(strength, Place(None, jnp.full(6, depth)))


def drift(*rises: float) -> AmbientDrift:
    return AmbientDrift(jnp.asarray(rises), duration=jnp.asarray(END))


MADE: dict[str, Callable[[float], Candidate]] = {
    "radiation": lambda value: MissingRadiation(one(value)),
    "local_convection": lambda value: LocalConvection(one(value), at(TOP, 0.004)),
    "support_contact": lambda value: supported(on_side(2, value)),
    # Behind the lit side, as coarse cells ripple where nothing has come yet.
    "backing_conduction": lambda value: BackingConduction(on_side(5, value)),
    "ambient_drift": lambda value: drift(0.5 * value, value),
    "evaporation": lambda value: Evaporation(one(value)),
}


@pytest.mark.parametrize("under", [hot(), lit()], ids=["hot", "lit"])
@pytest.mark.parametrize("name", list(MADE))
def test_strength_zero_changes_nothing(name: str, under: Conditions) -> None:
    candidate = MADE[name](0.0)
    assert candidate.card.name == name
    assert np.abs(change(candidate, under)).max() < 1e-9


@pytest.mark.parametrize(
    ("name", "strength", "under", "sign"),
    [
        ("radiation", 0.3, hot(), -1),
        ("radiation", -0.3, hot(), 1),
        ("local_convection", 100.0, hot(), -1),
        ("support_contact", 300.0, hot(), -1),
        # The backing is as warm as the body at first: it takes what the lamp brings.
        ("backing_conduction", 1000.0, lit(), -1),
        ("ambient_drift", 10.0, resting(), 1),
        ("ambient_drift", -10.0, resting(), -1),
        ("evaporation", 0.02, hot(), -1),
        # Air that is half saturated takes water from a body as warm as itself.
        ("evaporation", 0.02, resting(), -1),
    ],
)
def test_a_strength_cools_or_warms(
    name: str, strength: float, under: Conditions, sign: int
) -> None:
    moved = sign * change(MADE[name](strength), under)
    assert np.all(moved[0] == 0), "a body begins as it does without"
    assert moved[-1].mean() > 0.05 and moved[1:].mean(1).min() > 0
    # Ahead of a front, coarse cells ripple: in the end it has passed.
    assert moved[-1].min() > -0.02 * moved[-1].max()


def test_more_convection_on_a_patch_cools_the_patch_most() -> None:
    moved = change(MADE["local_convection"](100.0), hot())
    under_it, far = nearest(TOP), nearest((0.02, 0.012, 0.0))
    assert moved[-1, under_it] < 2 * moved[-1, far] < 0


@pytest.mark.parametrize("depth", [1e-9, 4e-6])
def test_a_flat_side_is_all_in_contact_where_nodes_lie_off_it(depth: float) -> None:
    fine = box_mesh((0.020, 0.012, 0.008), (5, 3, 2))
    noise = np.random.default_rng(3).uniform(-2e-5, 2e-5, len(fine.nodes))
    nodes = fine.nodes.copy()
    nodes[:, 2] += noise
    off = discretise(replace(fine, nodes=nodes))
    film = np.asarray(supported(on_side(2, 1.0), depth)._footprints(off))
    areas = (film * np.asarray(off.face_weight)[..., None]).sum((0, 1))
    # And of the walls beside it no more than the depth takes.
    for side in (2, 5):
        assert 0.020 * 0.012 <= areas[side] * (1 + 1e-5) <= 0.020 * 0.012 + 0.064 * depth + 1e-8


@pytest.mark.parametrize("tilt", [0.02, 0.2])
def test_a_side_that_leans_is_in_contact_where_it_ends(tilt: float) -> None:
    fine = box_mesh((0.020, 0.012, 0.008), (5, 3, 2))
    turn = np.array([[np.cos(tilt), 0, -np.sin(tilt)], [0, 1, 0], [np.sin(tilt), 0, np.cos(tilt)]])
    leaning = discretise(replace(fine, nodes=fine.nodes @ turn.T, normals=fine.normals @ turn.T))
    film = np.asarray(supported(on_side(2, 1.0), 4e-6)._footprints(leaning))[..., 2]
    area = float((film * np.asarray(leaning.face_weight)).sum())
    # A line of 12 mm along the edge, as wide as both sides that meet there go up by the depth.
    assert area < 1.2 * 0.012 * 4e-6 * (1 / np.sin(tilt) + 1 / np.cos(tilt))


@pytest.mark.parametrize("name", ["radiation", "local_convection", "evaporation", "ambient_drift"])
def test_what_air_and_surroundings_take_stops_where_it_is_insulated(name: str) -> None:
    left = solved(MADE[name](0.5).to_model(bare(wrapped()), wrapped()), wrapped())
    np.testing.assert_allclose(left, HOT, rtol=0, atol=1e-9)
    assert np.abs(change(MADE[name](0.5), hot())).max() > 1e-3


def test_a_support_and_a_backing_may_lie_behind_an_insulated_side() -> None:
    held = MADE["support_contact"](300.0).to_model(bare(wrapped()), wrapped())
    assert solved(held, wrapped())[-1].max() < HOT - 0.05
    model = MADE["backing_conduction"](500.0).to_model(bare(wrapped()), wrapped())
    effect = model.surface[-1]
    assert isinstance(effect, BackingFlow) and float(effect.effusivity.max()) == 500.0


def test_missing_radiation_adds_to_the_emissivity() -> None:
    moved = change(MissingRadiation(one(0.25)), hot())
    stated = replace(STATED, emissivity=STATED.emissivity + 0.25)
    wanted = solved(bare(hot(), stated), hot()) - solved(bare(hot()), hot())
    np.testing.assert_allclose(moved, wanted, rtol=0, atol=1e-9)


def test_convection_on_a_patch_far_larger_than_the_body_is_convection() -> None:
    moved = change(LocalConvection(one(15.0), at(TOP, 1e3)), hot())
    stated = replace(STATED, convection=STATED.convection + 15.0)
    wanted = solved(bare(hot(), stated), hot()) - solved(bare(hot()), hot())
    np.testing.assert_allclose(moved, wanted, rtol=0, atol=1e-8)


def test_patches_add_up() -> None:
    both = Place(jnp.asarray([TOP, (0.02, 0.006, 0.004)]), jnp.asarray([0.004, 0.006]))
    effect = LocalConvection(jnp.asarray([30.0, 50.0]), both).to_model(bare(hot()), hot())
    first = effect.surface[-1]
    assert isinstance(first, Convection)
    distance = ((SPACE.face_point[:, :, None] - np.asarray(both.centre)) ** 2).sum(-1)
    shape = np.exp(-distance / (2 * np.asarray(both.size) ** 2))
    np.testing.assert_allclose(first.coefficient, shape @ [30.0, 50.0], rtol=1e-12)


def test_a_patch_with_an_edge_is_even_within_it_and_may_lie_on_one_side_alone() -> None:
    lower = (0.01, 0.01, 0.0)
    even = Inclusion(
        jnp.asarray([lower]),
        jnp.asarray([[0.006, 0.006, 0.002]]),
        12 * jnp.ones(1),
        24 * jnp.ones(1),
    )
    effect = LocalConvection(one(30.0), even).to_model(bare(hot()), hot()).surface[-1]
    assert isinstance(effect, Convection)
    way = np.abs(SPACE.face_point - np.asarray(lower)) / [0.006, 0.006, 0.002]
    film, far = np.asarray(effect.coefficient), way.max(-1)
    np.testing.assert_allclose(film[far < 0.75], 30.0, rtol=1e-2)
    np.testing.assert_allclose(film[far > 1.2], 0.0, atol=1e-3)
    assert np.any(far < 0.75)


def contact_of(model: Model) -> np.ndarray:
    effect = model.surface[-1]
    assert isinstance(effect, Contact)
    return np.asarray(effect.conductance)


@pytest.fixture(scope="module")
def fine() -> Discretisation:
    """Six cells along each side."""
    return discretise(box_mesh(SIZE, (6, 6, 6)))


@pytest.mark.parametrize("reach", [1e-3, 0.13, 0.5])
@pytest.mark.parametrize("side", range(6), ids=SIDES)
def test_a_footprint_is_the_side_and_a_strip_of_its_walls(
    side: int, reach: float, fine: Discretisation
) -> None:
    sides = np.array(SIZE)
    axis = side % 3
    depth = reach * sides[axis]
    model = Model(fine, jnp.ones(len(fine.mesh.cells)), jnp.ones(len(fine.mesh.cells)))
    under = hot()
    found = contact_of(supported(on_side(side, 200.0), depth).to_model(model, under))
    across = np.delete(sides, axis)
    wanted = across.prod() + 2 * across.sum() * depth
    assert (found * fine.face_weight).sum() == pytest.approx(200.0 * wanted, rel=1e-9)
    normal = fine.mesh.normals[:, axis] * (1 if side >= 3 else -1)
    np.testing.assert_allclose(found[normal > 0.9], 200.0, rtol=1e-12)
    assert np.all(found[normal < -0.9] == 0.0)
    # How far up the walls it lies on average, as well.
    height = fine.face_point[..., axis]
    height = sides[axis] - height if side >= 3 else height
    middle = (found * fine.face_weight * height)[np.abs(normal) < 0.1].sum()
    assert middle == pytest.approx(200.0 * across.sum() * depth**2, rel=1e-9)


def test_a_support_is_as_warm_as_the_surroundings() -> None:
    held = supported(jnp.full(6, 50.0)).to_model(bare(hot()), hot()).surface[-1]
    shape = np.shape(SPACE.face_weight)
    assert np.all(np.asarray(held.flux(jnp.full(shape, AIR), 0.0)) == 0)
    covered = contact_of(supported(jnp.full(6, 50.0)).to_model(bare(hot()), hot()))
    lost = -np.asarray(held.flux(jnp.full(shape, HOT), 0.0))
    np.testing.assert_allclose(lost, (HOT - AIR) * covered)


@pytest.mark.parametrize("side", range(6), ids=SIDES)
def test_a_backing_takes_heat_through_its_side_as_a_half_space(side: int) -> None:
    under = lit()
    model = BackingConduction(on_side(side, 800.0)).to_model(bare(under), under)
    flow = model.surface[-1]
    assert isinstance(flow, BackingFlow)
    warm = jnp.full(np.shape(SPACE.face_weight), AIR + 20.0)
    # Carslaw and Jaeger: e dT / sqrt(pi t), here a second later than at the step itself.
    time = 8.0
    lost = -np.asarray(flow.flux(warm, time)) * SPACE.face_weight
    area = float(np.prod(np.delete(np.array(SIZE), side % 3)))
    wanted = 800.0 * 20.0 / np.sqrt(np.pi * (time + 1.0)) * area
    assert lost.sum() == pytest.approx(wanted, rel=1e-9)
    normal = SPACE.mesh.normals[:, side % 3] * (1 if side >= 3 else -1)
    assert np.all(lost[normal < 0.5] == 0)
    assert np.all(np.asarray(flow.flux(jnp.full_like(warm, AIR), time)) == 0)


def test_the_last_strength_of_a_drift_is_the_rise_at_the_end() -> None:
    model = drift(4.0, -2.0, 7.0).to_model(bare(lit()), lit())
    found = {type(one): one for one in model.surface}
    air, around = found[Convection], found[Radiation]
    assert isinstance(air, Convection) and isinstance(around, Radiation)
    assert isinstance(air.ambient, History) and isinstance(around.surroundings, History)
    for time, rise in [(0.0, 0.0), (END / 3, 4.0), (END / 2, 1.0), (2 * END / 3, -2.0), (END, 7.0)]:
        assert float(air.ambient.at(time)) == pytest.approx(AIR + rise)
        assert float(around.surroundings.at(time)) == AIR, "walls stay as they are"
    assert float(air.ambient.at(2 * END)) == pytest.approx(AIR + 7.0)
    assert [type(one) for one in model.surface] == [type(one) for one in bare(lit()).surface]


@pytest.mark.parametrize("stated", [True, False], ids=["none stated", "left out"])
def test_where_there_is_no_air_the_walls_drift(stated: bool) -> None:
    still = bare(lit(), replace(STATED, convection=0.0))
    kept = tuple(one for one in still.surface if stated or not isinstance(one, Convection))
    model = drift(4.0, -2.0).to_model(replace(still, surface=kept), lit())
    (around,) = (one for one in model.surface if isinstance(one, Radiation))
    assert isinstance(around.surroundings, History)
    for time, rise in [(0.0, 0.0), (END / 2, 4.0), (END, -2.0)]:
        assert float(around.surroundings.at(time)) == pytest.approx(AIR + rise)


def test_air_with_a_course_of_its_own_keeps_it_under_a_drift() -> None:
    model = bare(lit())
    own = History(jnp.asarray([0.0, END / 4, END]), jnp.asarray([AIR, AIR + 8.0, AIR + 2.0]))
    surface = tuple(
        replace(one, ambient=own) if isinstance(one, Convection) else one for one in model.surface
    )
    found = drift(4.0, -2.0).to_model(replace(model, surface=surface), lit())
    (air,) = (one for one in found.surface if isinstance(one, Convection))
    assert isinstance(air.ambient, History)
    for time, rise in [(0.0, 0.0), (END / 4, 2.0), (END / 2, 4.0), (3 * END / 4, 1.0), (END, -2.0)]:
        assert float(air.ambient.at(time)) == pytest.approx(float(own.at(time)) + rise)


def test_a_body_that_follows_the_air_drifts_with_it() -> None:
    stated = replace(STATED, convection=1e5, emissivity=0.0)
    under = resting()
    model = drift(3.0, 6.0).to_model(bare(under, stated), under)
    skin = np.unique(SPACE.mesh.faces)
    found = solved(model, under)[:, skin] - AIR
    np.testing.assert_allclose(
        found, np.repeat(6.0 * FRAMES[:, None] / END, len(skin), 1), atol=0.1
    )


def test_saturation_is_that_of_the_tables() -> None:
    # WMO: 611.2 Pa at 0, 2339 Pa at 20, 12350 Pa at 50 degrees Celsius.
    found = np.asarray(saturation(jnp.asarray([273.15, 293.15, 323.15])))
    np.testing.assert_allclose(found, [611.2, 2339.0, 12350.0], rtol=5e-3)


def test_vapour_falls_off_as_its_slope_says() -> None:
    vapour = Vapour(jnp.asarray([0.05]), jnp.asarray(AIR))
    level = jnp.asarray([[280.0, 300.0, 330.0]])
    slope = jax.jvp(lambda at: vapour.flux(at, 0.0), (level,), (jnp.ones_like(level),))[1]
    np.testing.assert_allclose(vapour.slope(level), -slope, rtol=1e-12)
    humid = 0.5 * float(saturation(jnp.asarray(AIR)))
    dew = float(np.interp(humid, np.asarray(saturation(jnp.linspace(270.0, AIR, 5001))),
                          np.linspace(270.0, AIR, 5001)))  # fmt: skip
    assert abs(float(vapour.flux(jnp.asarray([[dew]]), 0.0)[0, 0])) < 1e-3
