"""Rivals of an earlier effect, tried again beside those that came later."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest
from standings import standing
from verdicts import one_round

from thermo.discover import Card, _replacement
from thermo.discover._entries import Entry
from thermo.discover._pace import Pace
from thermo.discover._refits import Refit
from thermo.discover._replacement import replaced, rivals_of
from thermo.discover._scores import Score
from thermo.discover._standing import Standing

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
    # What was put first for being simpler need not be what leaves least.
    order = [made[1], made[0], made[3]]
    assert [one.name() for one in rivals_of(order, standing(200.0, 2))["near", 0]] == ["first"]


def tried(
    monkeypatch: pytest.MonkeyPatch,
    left: Mapping[str, float],
    sets: Sequence[Sequence[str]] = (("hidden_source",), ("void",)),
    free: int = 4,
) -> tuple[Standing, list[list[str]], list[str], list[str]]:
    """Where 100 squares are left by hidden_source and void, and so many by rivals of the first."""
    told: list[str] = []

    def other(_: Standing, number: int, rival: Refit, most: float) -> Standing:
        assert number == 0 and most == MOST
        active = (rival.standing.active[-1], LATER)
        return standing(left[rival.name()], free, active=active)

    effect: Any = one_round(["evaporation"], 0.9).effect
    monkeypatch.setattr(_replacement, "in_place_of", other)
    monkeypatch.setattr(_replacement, "effect_of", lambda *_: effect)
    rounds = [one_round(list(names), 0.9) for names in sets]
    here = standing(100.0, 4, active=(FIRST, LATER))
    rivals = {FIRST: [refit(name, 60.0) for name in left], LATER: [refit("never", 60.0)]}
    there, rounds, remarks = replaced(here, rounds, rivals, MOST, Pace(told.append))
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


def test_a_set_loses_only_what_was_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    sets = (["hidden_source", "heater_power"], ["void"])
    _, found, _, _ = tried(monkeypatch, {"heater_power": 200.0}, sets)
    assert found == [["hidden_source", "heater_power"], ["void"]]
    _, found, _, _ = tried(monkeypatch, {"radiation": 50.0, "void": 0.0}, sets)
    assert found == [["radiation", "heater_power"], ["void"]]
