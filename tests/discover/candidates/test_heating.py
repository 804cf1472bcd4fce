"""Effects on how heat comes in: none at strength zero, the right power, the right place."""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from lit_box import (
    AIR,
    FRAMES,
    NODES,
    OFF,
    SPACE,
    at,
    bare,
    change,
    hot,
    lit,
    nearest,
    one,
    power_into,
    resting,
    solved,
    within,
    without,
)

from thermo.discover import Candidate, Inclusion, Place
from thermo.discover.candidates import HeaterLag, HeaterPower, HiddenSource, InDepthAbsorption
from thermo.inverse import Conditions
from thermo.inverse._addition import extend
from thermo.physics import stored_heat
from thermo.physics._balance import assemble
from thermo.physics.effects import Heating, NodalSource

INSIDE = (0.006, 0.006, 0.004)  # m
LIT, BELOW = nearest((0.013, 0.006, 0.008)), nearest((0.013, 0.006, 0.0))
PULSE = jnp.asarray(0.12)  # s
DEPTHS = Place(None, jnp.asarray([0.001, 0.002, 0.004]))


def in_depth(*shares: float) -> InDepthAbsorption:
    return InDepthAbsorption(jnp.asarray(shares), DEPTHS)


MADE: dict[str, Callable[[float], Candidate]] = {
    "hidden_source": lambda value: HiddenSource(one(value), at(INSIDE, 0.003)),
    "heater_power": lambda value: HeaterPower(one(value)),
    "heater_lag": lambda value: HeaterLag(one(value), pulse=PULSE),
    "in_depth_absorption": lambda value: in_depth(0.0, value, 0.0),
}


@pytest.mark.parametrize("under", [hot(), lit()], ids=["hot", "lit"])
@pytest.mark.parametrize("name", list(MADE))
def test_strength_zero_changes_nothing(name: str, under: Conditions) -> None:
    candidate = MADE[name](0.0)
    assert candidate.card.name == name
    assert np.abs(change(candidate, under)).max() < 1e-9


@pytest.mark.parametrize("name", ["heater_power", "heater_lag", "in_depth_absorption"])
def test_what_lamps_do_wrong_does_not_show_without_one(name: str) -> None:
    assert np.abs(change(MADE[name](0.5), hot())).max() < 1e-9


@pytest.mark.parametrize("sign", [1, -1])
def test_a_hidden_source_warms_most_where_it_is(sign: int) -> None:
    moved = sign * change(MADE["hidden_source"](0.5 * sign), resting())
    near, far = nearest(INSIDE), nearest((0.02, 0.012, 0.008))
    assert np.all(moved[0] == 0) and np.all(np.diff(moved.mean(1)) > 0)
    assert moved[-1, near] > 2 * moved[-1, far] > 0


@pytest.mark.parametrize(("time", "level"), [(0.0, AIR), (1e4, AIR + 30.0)])
def test_hidden_sources_release_their_strengths_all_the_time(time: float, level: float) -> None:
    places = Place(jnp.asarray([INSIDE, (0.016, 0.003, 0.002)]), jnp.asarray([0.003, 0.005]))
    body, under = bare(resting()), resting()
    found = HiddenSource(jnp.asarray([0.5, 0.3]), places).to_model(body, under)
    more = power_into(found, level, time) - power_into(body, level, time)
    assert more == pytest.approx(0.8, rel=1e-9)


@pytest.mark.parametrize("share", [0.2, -0.5])
def test_heater_power_is_a_share_of_the_lamp_s(share: float) -> None:
    moved = change(HeaterPower(one(share)), lit())
    wanted = without(AIR, 1.2 * (1 + share)) - without(AIR, 1.2)
    np.testing.assert_allclose(moved, wanted, rtol=0, atol=1e-9)
    assert np.sign(share) * moved[-1, LIT] > 0.5


def test_heater_lag_is_the_rise_of_a_lamp() -> None:
    moved = change(HeaterLag(one(3.0), pulse=PULSE), lit())
    slow = lit(rise=3.0)
    np.testing.assert_allclose(
        moved, solved(bare(slow), slow) - without(AIR, 1.2), rtol=0, atol=1e-9
    )
    late = (FRAMES > 0) & (FRAMES <= OFF)
    assert np.all(moved[late, LIT] < -0.1), "a lamp that warms up brings less at first"


def test_the_slope_by_a_heater_s_lag_at_zero_foretells_a_small_lag() -> None:
    def lost(strength: jax.Array) -> jax.Array:
        # Heat that a lamp without losses would bring, by the trapezium rule over fine steps.
        model = HeaterLag(strength, pulse=PULSE).to_model(bare(lit()), lit())
        (lamp,) = (one for one in model.surface if isinstance(one, Heating))
        time = jnp.linspace(0.0, OFF, 3001)
        share = jax.vmap(lamp.schedule.share)(time)
        return jnp.sum(0.5 * (share[1:] + share[:-1])) * (time[1] - time[0])

    _, slope = jax.jvp(lost, (one(0.0),), (one(1.0),))
    small = (lost(one(0.1)) - lost(one(0.0))) / 0.1
    assert float(small) == pytest.approx(-1.0, rel=0.05)
    assert float(slope) == pytest.approx(float(small), rel=0.2)


@pytest.mark.parametrize(
    "shares", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.2, 0.3, 0.1)]
)
def test_light_that_reaches_below_the_surface_brings_the_same_power(
    shares: tuple[float, float, float],
) -> None:
    under = lit()
    found = in_depth(*shares).to_model(bare(under), under)
    for time, power in [(1.0, 1.2), (OFF + 1.0, 0.0)]:
        # As warm as the air, the body exchanges nothing.
        assert power_into(bare(under), AIR, time) == pytest.approx(power, abs=1e-12)
        assert power_into(found, AIR, time) == pytest.approx(power, abs=1e-12)
    (lamp,) = (one for one in found.surface if isinstance(one, Heating))
    assert float(lamp.power) == pytest.approx(1.2 * (1 - sum(shares)), abs=1e-12)


def test_light_that_reaches_below_the_surface_cools_it_and_warms_what_is_below() -> None:
    moved = change(in_depth(0.0, 0.0, 1.0), lit())
    on = (FRAMES > 0) & (FRAMES <= OFF)
    assert np.all(moved[on, LIT] < -0.5) and np.all(moved[on, BELOW] > 0.05)
    # What is stored differs only by what the surface loses less.
    store = assemble(bare(lit()))
    more, all_of_it = (
        float(jnp.sum(stored_heat(store, jnp.asarray(rise))))
        for rise in (moved[2], without(AIR, 1.2)[2] - AIR)
    )
    assert abs(more) < 0.02 * all_of_it


def test_light_falls_off_with_depth() -> None:
    under = lit()
    for share, size in [(in_depth(1, 0, 0.0), 1e-3), (in_depth(0, 1, 0.0), 2e-3)]:
        (source,) = share.to_model(bare(under), under).volume
        assert isinstance(source, NodalSource)
        rate = np.asarray(source.rate)
        assert rate.sum() == pytest.approx(1.2, rel=1e-9)
        # Mean depth of exp(-z / size) down to 8 mm, although cells are 4 mm high.
        mean = size - 0.008 / np.expm1(0.008 / size)
        assert rate @ (0.008 - NODES[:, 2]) / 1.2 == pytest.approx(mean, rel=0.02)
        # Along the surface it lies where the lamp's light does.
        lamp = np.asarray(under.profile) * np.asarray(SPACE.face_weight)
        across = (lamp[..., None] * SPACE.face_point[..., :2]).sum((0, 1))
        np.testing.assert_allclose(rate @ NODES[:, :2] / 1.2, across, atol=4e-4)


@pytest.mark.parametrize("place", [at(INSIDE, 0.0015), within(INSIDE, [0.004, 0.002, 0.002])])
def test_heat_released_inside_is_released_about_its_place(place: Place | Inclusion) -> None:
    (source,) = HiddenSource(one(2.0), place).to_model(bare(hot()), hot()).volume
    assert isinstance(source, NodalSource)
    rate = np.asarray(source.rate)
    assert rate.sum() == pytest.approx(2.0, rel=1e-9)
    np.testing.assert_allclose(rate @ NODES / 2.0, INSIDE, atol=3e-4)


def test_light_below_the_surface_is_that_of_a_lamp_that_is_stronger() -> None:
    under = lit()
    both = (HeaterPower(one(0.2)), in_depth(0.0, 1.0, 0.0))
    found = extend(bare(under), under, both)
    assert power_into(found, AIR, 1.0) == pytest.approx(1.2 * 1.2, rel=1e-9)
