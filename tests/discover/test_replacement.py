"""Rivals of an earlier effect, tried again beside those that came later."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from standings import standing
from verdicts import fitted_in, one_round

from thermo.discover import Card, Place, _replacement
from thermo.discover._candidate import Candidate, Transition
from thermo.discover._entries import Entry
from thermo.discover._extended import Extended
from thermo.discover._pace import Pace
from thermo.discover._refits import Refit
from thermo.discover._replacement import replaced, rivals_of
from thermo.discover._rounds import with_set
from thermo.discover._scores import Score
from thermo.discover._standing import Standing
from thermo.discover.candidates import HeaterPower, HiddenSource, LatentHeat

FIRST, LATER = ("hidden_source", 0), ("void", 2)
MOST = 12.0


def refit(name: str, left: float, *, fault: bool = False) -> Refit:
    card = Card(name, "1", 1.0, -np.inf, np.inf, "", "", "", fault=fault)
    score = Score(Entry(0, 0, card, np.array([0])), 5.0, np.ones(1), 0.2, 1.0, 0.3, slice(0, 1))
    there = standing(left, 3, active=((name, 0),))
    return Refit(score, there, there)


def test_rivals_are_effects_near_the_first_of_their_round() -> None:
    made = [
        refit("first", 50.0), refit("near", 60.0), refit("fault", 55.0, fault=True),
        refit("far", 180.0),
    ]  # fmt: skip
    found = rivals_of(made, standing(200.0, 2))
    assert {key: [one.name() for one in each] for key, each in found.items()} == {
        ("first", 0): ["near"]
    }
    found = rivals_of(made, standing(200.0, 2), ["first", "far", "fault"])
    assert [one.name() for one in found["first", 0]] == ["near", "far"]
    # What was put first for being simpler need not be what leaves least.
    order = [made[1], made[0], made[3]]
    assert [one.name() for one in rivals_of(order, standing(200.0, 2))["near", 0]] == ["first"]


def tried(
    monkeypatch: pytest.MonkeyPatch,
    left: Mapping[str, float],
    sets: Sequence[Sequence[str]] = (("hidden_source",), ("void",)),
    free: int = 4,
    closed: float = 0.9,
    alone: float = 0.0,
    same: bool = True,
) -> tuple[Standing, list[list[str]], list[str], list[str]]:
    """Where 100 squares are left by hidden_source and void, and so many by rivals of the first.

    The first had `closed` a share of the gap; void `alone` leaves so much. A rival that is a void
    is the `same` one.
    """
    told: list[str] = []

    def other(_: Standing, number: int, rival: Refit, most: float) -> Standing:
        assert number == 0 and most == MOST
        active = (rival.standing.active[-1], LATER)
        return standing(left[rival.name()], free, active=active)

    effect: Any = one_round(["evaporation"], 0.9).effect
    monkeypatch.setattr(_replacement, "in_place_of", other)
    monkeypatch.setattr(_replacement, "effect_of", lambda *_: effect)
    monkeypatch.setattr(_replacement, "alternative_of", lambda _, active, __: fitted_in(active[0]))

    def fitted(one: Standing, *, times: int, rival: float) -> Standing:
        # Half of 100 squares, of the 12 by which it may be behind, and four entries.
        assert (one.active, times) == ((LATER,), 0) and rival == pytest.approx(50 + 6 + 4)
        return standing(alone, 3)

    less = {"without": lambda *_: standing(1e3, 3, active=(LATER,)), "fitted": fitted}
    for name, fake in less.items():
        monkeypatch.setattr(_replacement, name, fake)
    monkeypatch.setattr(
        _replacement, "_is_at_work", lambda _, rival: same and rival.name() == "void"
    )
    rounds = [one_round(list(names), closed) for names in sets]
    here = standing(100.0, 4, active=(FIRST, LATER))
    rivals = {FIRST: [refit(name, 60.0) for name in left], LATER: [refit("never", 60.0)]}
    there, rounds, remarks = replaced(here, rounds, rivals, MOST, Pace(told.append))
    for one in rounds:
        # All of a set but its best, those that were tried again as they were fitted then.
        assert list(one.alternatives) == one.together[1:]
    return there, [one.together for one in rounds], remarks, told


@pytest.mark.parametrize(
    ("left", "found"),
    [
        (100.0 - MOST - 1, ["radiation"]), (100.0 - MOST + 1, ["hidden_source", "radiation"]),
        (100.0 + MOST - 1, ["hidden_source", "radiation"]), (100.0 + MOST + 1, ["hidden_source"]),
    ],
)  # fmt: skip
def test_a_rival_takes_the_place_stays_beside_or_is_left(
    monkeypatch: pytest.MonkeyPatch, left: float, found: list[str]
) -> None:
    there, sets, remarks, told = tried(monkeypatch, {"radiation": left})
    assert sets == [found, ["void"]] and told == ["trying radiation in place of hidden_source"]
    took = found[0] == "radiation"
    assert there.active[0] == (("radiation", 0) if took else FIRST)
    assert remarks == (
        ["radiation took the place of hidden_source beside what came later."] if took else []
    )


def test_more_that_is_free_is_paid_for_to_take_a_place_not_to_stay(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Twenty squares less with six entries more: eight by the criterion.
    _, sets, _, _ = tried(monkeypatch, {"radiation": 80.0}, free=10)
    assert sets[0] == ["hidden_source", "radiation"]
    _, sets, _, _ = tried(monkeypatch, {"radiation": 110.0}, free=10)
    assert sets[0] == ["hidden_source", "radiation"]


def test_what_was_tried_again_is_told_as_it_was_fitted_then() -> None:
    names, anew = ["hidden_source", "radiation", "void"], fitted_in("void")
    first = {name: fitted_in(name) for name in ("hidden_source", "radiation")}
    one = replace(one_round(["hidden_source"], 0.9), alternatives=first)
    more = with_set(one, names, anew)
    assert more.together == names and list(more.alternatives) == names[1:]
    assert more.alternatives["radiation"] is first["radiation"]
    assert more.alternatives["void"] is anew
    again = fitted_in("void")
    assert with_set(more, names, again).alternatives["void"] is again
    assert list(with_set(more, ["radiation", "void"]).alternatives) == ["void"]


def test_a_set_loses_only_what_was_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    sets = (["hidden_source", "heater_power"], ["void"])
    _, found, _, _ = tried(monkeypatch, {"heater_power": 200.0}, sets)
    assert found == [["hidden_source", "heater_power"], ["void"]]
    _, found, _, _ = tried(monkeypatch, {"radiation": 50.0, "void": 0.0}, sets)
    assert found == [["radiation", "heater_power"], ["void"]]


@pytest.mark.parametrize(
    ("closed", "left", "kept"),
    [(0.6, 200.0, True), (0.4, 200.0, False), (0.4, 100.0 + MOST - 1, True)],
)
def test_what_a_round_with_most_of_the_gap_left_told_together_is_told_apart_later(
    monkeypatch: pytest.MonkeyPatch, closed: float, left: float, kept: bool
) -> None:
    sets = (["hidden_source", "heater_power"], ["void"])
    _, found, _, _ = tried(monkeypatch, {"heater_power": left}, sets, closed=closed)
    assert found == [["hidden_source", *["heater_power"] * kept], ["void"]]


@pytest.mark.parametrize(
    ("closed", "alone", "same", "kept"),
    [
        (0.4, 100.0 + MOST + 3, True, False),
        (0.4, 100.0 + MOST - 1, True, True),
        (0.4, 200.0, False, True),
        (0.6, 200.0, True, True),
    ],
)
def test_what_is_at_work_later_is_no_rival_of_what_it_needs_beside_it(
    monkeypatch: pytest.MonkeyPatch, closed: float, alone: float, same: bool, kept: bool
) -> None:
    sets, more = (["hidden_source", "void"], ["void"]), {"closed": closed, "same": same}
    _, found, _, told = tried(monkeypatch, {"void": 0.0}, sets, alone=alone, **more)
    assert found == [["hidden_source", *["void"] * kept], ["void"]]
    assert told == ["trying without hidden_source"] * (same and closed < 0.5)


def test_a_rival_is_at_work_where_it_is_not_elsewhere() -> None:
    where = Place(jnp.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), jnp.array([0.1, 0.1]))
    bell = Transition(jnp.array([300.0, 320.0]), jnp.array([5.0, 5.0]))
    two, one = jnp.zeros(2), jnp.zeros(1)
    kinds = (
        HiddenSource(two, where), LatentHeat(two, bell, jnp.array(2700.0)), HeaterPower(one)
    )  # fmt: skip
    active = (("hidden_source", 1), ("latent_heat", 0), ("heater_power", 0))
    here = with_point(standing(100.0, 4, active=active), kinds)

    def at_work(name: str, part: int, *kinds: Candidate) -> bool:
        one = refit(name, 60.0)
        there = with_point(standing(60.0, 3, active=((name, part),)), kinds)
        return _replacement._is_at_work(here, replace(one, standing=there))

    moved = replace(where, centre=where.centre + jnp.array([0.05, 0.05, 0.0]))
    assert at_work("hidden_source", 1, HiddenSource(two, moved))
    assert not at_work("hidden_source", 0, HiddenSource(two, moved)), "that part is not at work"
    far = replace(where, centre=where.centre + jnp.array([0.0, 0.2, 0.0]))
    assert not at_work("hidden_source", 1, HiddenSource(two, far))
    assert at_work("latent_heat", 0, kinds[1]) and not at_work("latent_heat", 1, kinds[1])
    assert at_work("heater_power", 0, kinds[2])
    assert not at_work("void", 0), "nothing of that kind is at work"


def with_point(one: Standing, kinds: tuple[Candidate, ...]) -> Standing:
    object.__setattr__(one, "point", Extended({}, kinds))
    return one
