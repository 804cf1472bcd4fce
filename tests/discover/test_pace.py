"""What is said of a step, and of the time that is left."""

from __future__ import annotations

import pytest

from thermo.discover._pace import MEASURE, REFIT, Pace, silent


class Clock:
    """A clock that is put forward by hand [s]."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_time_left_is_told_once_every_kind_ahead_was_made() -> None:
    said: list[str] = []
    clock = Clock()
    pace = Pace(said.append, clock=clock)
    steps = [
        ("stated", MEASURE, None, 10.0),
        ("scoring", "", None, 50.0),
        ("one", REFIT, {REFIT: 3, MEASURE: 2}, 40.0),
        ("two", REFIT, {REFIT: 2, MEASURE: 2}, 4.0),
        ("three", REFIT, {REFIT: 1, MEASURE: 2}, 6.0),
        ("measured", MEASURE, {MEASURE: 2}, 14.0),
        ("again", MEASURE, {MEASURE: 1}, 1.0),
    ]
    for words, kind, ahead, seconds in steps:
        pace.step(words, kind, ahead)
        clock.now += seconds
    left = "; {} or more left in this round"
    assert said == [
        "stated", "scoring", "one",
        "two" + left.format("1 min 40 s"),
        "three" + left.format("42 s"),
        "measured" + left.format("20 s"),
        "again" + left.format("12 s"),
    ]  # fmt: skip


def test_what_was_found_again_counts_as_long_as_it_had_taken() -> None:
    clock, spared, said = Clock(), [3.0], list[str]()
    pace = Pace(said.append, spared, clock)
    pace.step("one", REFIT)
    spared += [20.0, 5.0]
    clock.now += 1.0
    pace.step("two", REFIT, {REFIT: 2})
    clock.now += 30.0
    pace.step("three", REFIT, {REFIT: 1})
    told = "; {} s or more left in this round"
    assert said[1].endswith(told.format(52)), "the 3 s were before its first step"
    assert said[2].endswith(told.format(28))


def test_nothing_is_made_up() -> None:
    pace = silent()
    pace.step("one", REFIT)
    assert pace.left({}) is None and pace.left({MEASURE: 1}) is None
    pace.step("two")
    assert pace.left({REFIT: 2}) == pytest.approx(0.0, abs=0.1)
    assert pace.left({REFIT: 2, MEASURE: 1}) is None
