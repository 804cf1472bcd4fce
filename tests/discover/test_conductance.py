"""What a film takes over all of its place, against areas that are known."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree
from lit_box import FRAMES, MESH, SIZE, at, one

from thermo.discover import Candidate, Place
from thermo.discover._conductance import conductance_of, strength_between
from thermo.discover._extended import Extended
from thermo.discover._standing import free_of
from thermo.discover.candidates import (
    AmbientDrift,
    CameraEmissivity,
    HeaterPower,
    LocalConvection,
    SupportContact,
)
from thermo.inverse import Objective
from thermo.physics import discretise

from .lit_objective import objective as made
from .lit_objective import standing_at

X, Y, Z = SIZE
DEPTH = 0.004  # m
FIRST = 0.001  # m, of a depth


@pytest.fixture(scope="module")
def objective() -> Objective:
    return made()


def taken(objective: Objective, candidate: Candidate) -> float | None:
    found = told(objective, candidate)
    return None if found is None else found[0]


def told(
    objective: Objective, candidate: Candidate, ways: np.ndarray | None = None
) -> tuple[float, float] | None:
    """With errors of the entries that are free along `ways`, each row one deviation [1]."""
    standing = standing_at(objective, candidate)
    free = free_of(standing)
    ways = np.zeros((1, len(free.number))) if ways is None else ways
    return conductance_of(standing, standing.active[0], free, ways.T @ ways)


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


def test_it_is_known_where_h_and_its_reach_make_up_for_each_other(objective: Objective) -> None:
    patch = LocalConvection(one(300.0), at((0.01, 0.006, 0.008), 0.002))
    free = free_of(standing_at(objective, patch))
    lone = np.zeros((1, len(free.number)))
    sizes = ravel_pytree(Extended({}, (patch,)))[0]
    first = len(ravel_pytree(standing_at(objective, patch).point.fields)[0])
    strength, size = (
        int(np.flatnonzero(free.number == first + at)[0])
        for at in (int(np.argmax(sizes == 300.0)), int(np.argmax(sizes == 0.002)))
    )
    # A tenth more in the middle, alone.
    lone[0, strength] = 30.0 / free.scale[strength]
    found = told(objective, patch, lone)
    assert found is not None and found[1] == pytest.approx(0.1 * found[0], rel=1e-6)
    # h times size squared stays as it is on a flat face, far from its ends.
    lone[0, size] = -0.5 * 0.1 * 0.002 / free.scale[size]
    both = told(objective, patch, lone)
    assert both is not None and both[1] < 0.25 * found[1]


def leaning(
    objective: Objective, turn: float, share: float, error: float = 0.0
) -> tuple[float, float] | None:
    """Between which a contact is, of 2 to 3 mW/K, whose depth is a share of the first one [1].

    The box is turned about z [rad], so that an edge of it lies at the end in question; `error` of
    the depth [m].
    """
    way = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    body = replace(objective, space=discretise(replace(MESH, nodes=MESH.nodes @ way.T)))
    first = SupportContact(jnp.zeros(6).at[0].set(200.0), Place(None, jnp.full(6, FIRST)))
    standing = standing_at(body, first)
    there = replace(first, place=Place(None, jnp.full(6, share * FIRST)))
    standing = replace(standing, point=replace(standing.point, candidates=(there,)))
    free = free_of(standing)
    covariance = np.zeros((len(free.number), len(free.number)))
    covariance[-1, -1] = (error / free.scale[-1]) ** 2
    return strength_between(standing, standing.active[0], free, covariance, (0.002, 0.003))


def test_of_a_contact_along_a_line_only_its_whole_is_known(objective: Objective) -> None:
    # Two strips along the edge and a corner at each end of it, at most as deep as four first ones.
    least, most = (2 * d * (np.sqrt(2) * Z + d) for d in (1e-3 * FIRST, 4 * FIRST))
    told = pytest.approx((0.002 / most, 0.003 / least), rel=0.05)
    assert leaning(objective, np.pi / 4, SupportContact.card.smallest) == told
    assert leaning(objective, np.pi / 4, 0.1, 0.1 * FIRST) == told, "a depth that may be none"
    assert leaning(objective, np.pi / 4, 0.1, 0.01 * FIRST) is None, "a depth that is known"
    assert leaning(objective, 0.0, SupportContact.card.smallest) is None, "on a flat side"


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
