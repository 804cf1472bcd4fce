"""What a film takes over all of its place, against areas that are known."""

from __future__ import annotations

import jax.numpy as jnp
import pytest
from lit_box import FRAMES, SIZE, at, one

from thermo.discover import Candidate, Place
from thermo.discover._conductance import conductance_of
from thermo.discover.candidates import (
    AmbientDrift,
    CameraEmissivity,
    HeaterPower,
    LocalConvection,
    SupportContact,
)
from thermo.inverse import Objective

from .lit_objective import objective as made
from .lit_objective import standing_at

X, Y, Z = SIZE
DEPTH = 0.004  # m


@pytest.fixture(scope="module")
def objective() -> Objective:
    return made()


def taken(objective: Objective, candidate: Candidate) -> float | None:
    standing = standing_at(objective, candidate)
    return conductance_of(standing, standing.active[0])


def test_all_over_it_is_h_times_the_surface(objective: Objective) -> None:
    found = taken(objective, LocalConvection(one(7.0), at((0.0, 0.0, 0.0), 100.0)))
    assert found == pytest.approx(7.0 * 2 * (X * Y + Y * Z + Z * X), rel=1e-6)


def test_of_several_places_it_is_that_of_the_one_at_work(objective: Objective) -> None:
    place = Place(jnp.zeros((2, 3)), jnp.asarray([100.0, 50.0]))
    found = taken(objective, LocalConvection(jnp.asarray([-3.0, 40.0]), place))
    assert found == pytest.approx(-3.0 * 2 * (X * Y + Y * Z + Z * X), rel=1e-6)


def test_a_support_holds_its_side_and_what_lies_up_to_its_depth(objective: Objective) -> None:
    support = SupportContact(jnp.zeros(6).at[0].set(200.0), Place(None, jnp.full(6, DEPTH)))
    found = taken(objective, support)
    # Its edge falls between the points of the rule on faces that are wider than it is deep.
    assert found == pytest.approx(200.0 * (Y * Z + 2 * (Y + Z) * DEPTH), rel=0.08)


@pytest.mark.parametrize(
    "candidate",
    [
        CameraEmissivity(one(0.1)),
        HeaterPower(one(0.1)),
        AmbientDrift(one(5.0), duration=jnp.asarray(FRAMES[-1])),
    ],
    ids=lambda each: each.card.name,
)
def test_what_adds_no_film_takes_none(objective: Objective, candidate: Candidate) -> None:
    assert taken(objective, candidate) is None
