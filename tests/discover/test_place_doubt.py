"""What is read were a part of an effect elsewhere counts as an error that is allowed for."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from lit_box import at, one, within

from thermo.discover import Inclusion, Place, _place_doubt
from thermo.discover._allowance import Allowance, allowance
from thermo.discover._candidate import Transition
from thermo.discover._entries import Active, Entry
from thermo.discover._extended import Extended, readings, whitened
from thermo.discover._place_doubt import clear_of_shapes, with_doubt
from thermo.discover._scores import Score, ScoreTable
from thermo.discover._standing import Standing
from thermo.discover.candidates import (
    CameraEmissivity,
    HeaterPower,
    InDepthAbsorption,
    LatentHeat,
    LocalConvection,
    Void,
)
from thermo.inverse import Objective, penalty

from .lit_objective import objective as made
from .lit_objective import standing_at as standing

TOP, SIZE = (0.013, 0.006, 0.008), 0.005  # m


@pytest.fixture(scope="module")
def objective() -> Objective:
    return made()


@pytest.fixture(autouse=True)
def as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """No fit: what is allowed for is looked at."""
    monkeypatch.setattr(_place_doubt, "fitted", lambda standing, **_: standing)


def change(objective: Objective, before: Extended, after: Extended) -> np.ndarray:
    both = zip(readings(objective, before), readings(objective, after), strict=True)
    apart = [b - a for a, b in both]
    white = np.asarray(whitened(objective, apart))
    others = penalty(objective, before.fields).size + len(objective.sequence)
    return np.append(white, np.zeros(others))[:, None]


def test_a_patch_half_as_wide_is_within_what_is_allowed(objective: Objective) -> None:
    patch = LocalConvection(one(3e4), at(TOP, SIZE))
    before = standing(objective, patch)
    after = with_doubt(before, before.allowed)
    narrow = LocalConvection(one(3e4), at(TOP, SIZE / 2))
    told = change(objective, before.point, Extended(before.point.fields, (narrow,)))
    assert np.linalg.norm(told) > 30, "the patch would be seen to be another one"
    # Of variance one at most as large as fifteen per cent of it.
    assert np.linalg.norm(after.allowed.whiten(told)) < 1 / 0.15 + 1e-6
    stranger = np.random.default_rng(0).normal(size=told.shape)
    stranger[0] = 0.0
    kept = np.linalg.norm(after.allowed.whiten(stranger)) / np.linalg.norm(stranger)
    assert kept > 0.9, "what no place explains stays"


def test_a_patch_with_an_edge_takes_as_much_elsewhere(objective: Objective) -> None:
    # Off the skin, or half as thick, it would take nothing, and its strength would seem unknown.
    flat = within(TOP, [SIZE, SIZE, 0.001])
    before = standing(objective, LocalConvection(one(3e4), flat))
    after = with_doubt(before, before.allowed)
    stronger = LocalConvection(one(3.3e4), flat)
    told = change(objective, before.point, Extended(before.point.fields, (stronger,)))
    kept = [np.linalg.norm(each.allowed.whiten(told)) for each in (before, after)]
    assert kept[1] > 0.3 * kept[0] > 0


def test_a_patch_that_would_lie_beside_the_body_tells_of_no_error(
    objective: Objective, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = standing(objective, LocalConvection(one(3e4), within(TOP, [SIZE, SIZE, 0.001])))

    def taken_by(standing: Standing, _: Active, point: Extended) -> jnp.ndarray:
        return jnp.asarray(1.0 if point is standing.point else 0.09)

    monkeypatch.setattr(_place_doubt, "taken_by", taken_by)
    assert with_doubt(before, before.allowed) is before


def test_what_bursts_elsewhere_tells_of_no_error(
    objective: Objective, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = standing(objective, LocalConvection(one(3e4), at(TOP, SIZE)))
    monkeypatch.setattr(
        _place_doubt, "whitened", lambda *_: np.full(len(before.ended.residual), np.inf)
    )
    after = with_doubt(before, before.allowed)
    values = np.random.default_rng(3).normal(size=(len(before.ended.residual), 1))
    np.testing.assert_allclose(after.allowed.whiten(values), before.allowed.whiten(values))


def test_doubts_do_not_pile_up(objective: Objective) -> None:
    before = standing(objective, LocalConvection(one(300.0), at(TOP, SIZE)))
    plain = before.allowed
    once = with_doubt(before, plain)
    twice = with_doubt(once, plain)
    values = np.random.default_rng(1).normal(size=(len(plain.lost), 1))
    np.testing.assert_allclose(once.allowed.whiten(values), twice.allowed.whiten(values))


def test_an_effect_without_a_place_leaves_no_doubt(objective: Objective) -> None:
    before = standing(objective, CameraEmissivity(one(0.1)))
    assert with_doubt(before, before.allowed) is before


def test_doubt_that_has_no_ground_any_more_goes(objective: Objective) -> None:
    patch, camera = LocalConvection(one(300.0), at(TOP, SIZE)), CameraEmissivity(one(0.1))
    before = standing(objective, camera)
    plain = before.allowed
    doubted = with_doubt(standing(objective, patch), plain).allowed
    assert with_doubt(replace(before, allowed=doubted), plain).allowed is plain


def test_places_change_one_way_each_and_stay_in_the_body() -> None:
    corners = np.array([[0.0, 0.0, 0.0], [0.02, 0.012, 0.008]])
    place = Place(jnp.array([[0.001, 0.006, 0.004], list(TOP)]), jnp.array([SIZE, SIZE]))
    found = _place_doubt._places(place, 1, corners)
    assert len(found) == 8
    for one_way in found:
        assert isinstance(one_way, Place) and one_way.centre is not None
        np.testing.assert_array_equal(one_way.centre[0], [0.001, 0.006, 0.004])
        assert np.all(one_way.centre[1] <= corners[1])
    sizes = [float(one_way.size[1]) for one_way in found]
    assert sizes[:2] == [SIZE / 2, 2 * SIZE] and set(sizes[2:]) == {SIZE}


def test_a_patch_is_elsewhere_along_the_skin_alone() -> None:
    flat = within(TOP, [0.004, 0.003, 0.001])
    corners = np.array([[0.0, 0.0, 0.0], [0.02, 0.012, 0.008]])
    narrow, wide, *moved = _place_doubt._places(flat, 0, corners, np.array([1.0, 0.7, 0.0]))
    np.testing.assert_allclose(narrow.size, [[0.002, 0.003 / 2**0.7, 0.001]])
    np.testing.assert_allclose(wide.size, [[0.008, 0.003 * 2**0.7, 0.001]])
    assert len(moved) == 4
    for one_way in moved:
        assert isinstance(one_way, Inclusion) and float(one_way.centre[0, 2]) == TOP[2]


def test_a_depth_and_a_transition_have_fewer_ways() -> None:
    corners = np.zeros((2, 3))
    depth = InDepthAbsorption(jnp.zeros(2), Place(None, jnp.array([1e-3, 2e-3]))).place
    assert len(_place_doubt._places(depth, 0, corners)) == 2
    bell = Transition(jnp.array([330.0]), jnp.array([4.0]))
    found = _place_doubt._places(bell, 0, corners)
    middles = sorted(float(one.centre[0]) for one in found if isinstance(one, Transition))
    assert middles == [326.0, 330.0, 330.0, 334.0]


def test_columns_beside_others_are_allowed_for_as_all_together() -> None:
    make = np.random.default_rng(2)
    errors = make.normal(size=(30, 5))
    values = make.normal(size=(30, 2))
    whole = allowance([], errors)
    parts = _place_doubt.beside(allowance([], errors[:, :2]), errors[:, 2:])
    assert isinstance(parts, Allowance)
    np.testing.assert_allclose(parts.whiten(values), whole.whiten(values), atol=1e-10)


def scores_of(**scores: float) -> ScoreTable:
    kinds = {"void": Void.card, "heater_power": HeaterPower.card, "latent_heat": LatentHeat.card,
             "in_depth_absorption": InDepthAbsorption.card}  # fmt: skip
    made = [
        Score(Entry(0, 0, kinds[name], np.array([0])), z, np.ones(1), 0.2, 1.0, 0.3, slice(0, 1))
        for name, z in scores.items()
    ]
    return ScoreTable(made, [], 3.5, np.eye(1), np.zeros((9, 1)))


@pytest.mark.parametrize(
    ("scores", "kept"),
    [
        ({"void": 90.0, "heater_power": 6.9}, []),
        ({"void": 90.0, "heater_power": -7.1}, ["heater_power"]),
        ({"heater_power": 5.0, "latent_heat": 7.1}, ["heater_power", "latent_heat"]),
        ({"in_depth_absorption": 7.5, "void": 9.0}, ["in_depth_absorption"]),
        # Nothing absorbs less than none of its light below the surface.
        ({"in_depth_absorption": -11.0, "heater_power": 4.0}, []),
        ({}, []),
    ],
)
def test_beside_places_a_score_of_what_is_all_over_the_body_tells_where_it_is_large(
    scores: dict[str, float], kept: list[str]
) -> None:
    zero = jnp.zeros(1)
    kinds = {
        "void": Void(zero, within((0.01, 0.01, 0.01), [0.002, 0.002, 0.002])),
        "heater_power": HeaterPower(zero),
        "latent_heat": LatentHeat(zero, Transition(zero, zero), jnp.array(2700.0)),
        "in_depth_absorption": InDepthAbsorption(zero, Place(None, zero)),
    }
    table = scores_of(**scores)
    left = clear_of_shapes(table, kinds)
    assert [one.name() for one in left.scores] == kept
    # What is not followed is kept to be told of.
    over_all = [one for one in table.scores if one.name() != "void"]
    assert list(left.unfollowed) == ([] if kept else over_all)
    assert left.threshold == table.threshold, "what rivals are compared by stays"
