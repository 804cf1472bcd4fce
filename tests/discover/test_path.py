"""The rule by which a search goes on and stops, on rounds made by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from standings import standing
from verdicts import one_round

from thermo.discover import Calibration, Round, _path
from thermo.discover._path import SearchPath, search
from thermo.discover._scores import ScoreTable
from thermo.discover.candidates import CameraDrift


def found(low: float, high: float, closed: float) -> Round:
    made, chance = one_round(["hidden_source"], closed), 0.2 if low <= 0 <= high else 0.001
    return replace(made, effect=replace(made.effect, interval95=(low, high), chance=chance))


def searched(
    monkeypatch: pytest.MonkeyPatch, left: Sequence[float], rounds: Sequence[Round], alarms: int
) -> SearchPath:
    """A search whose standings leave so much, with so many alarms by scores."""
    standings = [standing(told + 50.0, 2, smooth=told) for told in left]
    table = ScoreTable([], [], 3.4, np.zeros((0, 0)), np.zeros((0, 0)))
    raised = iter([True] * alarms + [False] * 9)
    made, order = iter(rounds), iter(standings[1:])
    fakes: dict[str, Any] = {
        "scored": lambda *_, **__: table,
        "_alarm": lambda _: next(raised),
        "refits": lambda *_: [None],
        "effects_first": lambda made, _: made,
        "make_round": lambda *_: next(made),
        "with_all": lambda *_: next(order),
        "with_joint_effects": lambda rounds, _: rounds,
        "calibrated": lambda *_: Calibration(np.ones(9), 0.04, 0.01, 0.05),
    }
    for name, fake in fakes.items():
        monkeypatch.setattr(_path, name, fake)
    return search(standings[0], (), lambda _: None)


def test_an_effect_that_may_be_nothing_is_not_named_where_nothing_else_is_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = searched(monkeypatch, [1.0], [found(0.0, 0.5, 0.1)], alarms=1)
    assert path.word == "no_gap" and path.rounds == []
    assert "hidden_source passes the threshold" in path.remarks[0]
    assert "[0, 0.5] W" in path.remarks[0]


def test_one_that_cannot_be_nothing_is(monkeypatch: pytest.MonkeyPatch) -> None:
    path = searched(monkeypatch, [1.5, 1.0], [found(0.1, 0.5, 0.9)], alarms=1)
    assert path.word == "named" and len(path.rounds) == 1 and path.remarks == []


def test_a_gap_in_smooth_shapes_is_not_argued_away(monkeypatch: pytest.MonkeyPatch) -> None:
    path = searched(monkeypatch, [5000.0, 1.0], [found(-0.1, 0.5, 0.9)], alarms=1)
    assert path.word == "named" and len(path.rounds) == 1


def test_a_second_effect_that_may_be_nothing_ends_the_search(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rounds = [found(0.1, 0.5, 0.9), found(-1.0, 1.0, 0.9)]
    path = searched(monkeypatch, [5000.0, 1.5], rounds, alarms=2)
    assert path.word == "named" and len(path.rounds) == 1 and len(path.remarks) == 1


def test_a_fault_of_the_record_is_told_of_and_not_named(monkeypatch: pytest.MonkeyPatch) -> None:
    drift = found(0.001, 0.003, 0.99)
    drift = replace(drift, effect=replace(drift.effect, card=CameraDrift.card, strength=0.002))
    path = searched(monkeypatch, [5000.0], [drift], alarms=1)
    assert path.word == "none_of_mine" and path.rounds == []
    assert "camera_drift of 0.002 K/s" in path.remarks[0] and "known temperature" in path.remarks[0]


def pruned_to(
    monkeypatch: pytest.MonkeyPatch, after: float, first: tuple[float, float] = (0.1, 0.5)
) -> tuple[list[Round], list[str]]:
    """Two rounds, the second of which may be nothing, where the fit without it leaves `after`."""
    both = (("hidden_source", 0), ("radiation", 0))
    now = standing(120.0, 4, active=both)
    rounds = [found(*first, 0.9), found(-1.0, 1.0, 0.9)]
    effects = dict(zip(now.active, [one.effect for one in rounds], strict=True))
    fakes: dict[str, Any] = {
        "effect_of": lambda _, active, __: effects[active],
        "without": lambda _, number: standing(120.0, 3, active=both[:number]),
        "fitted": lambda made, **_: standing(after, 3, active=made.active),
    }
    for name, fake in fakes.items():
        monkeypatch.setattr(_path, name, fake)
    remarks: list[str] = []
    last, kept = _path.pruned(now, rounds, 9.0, lambda _: None, remarks)
    assert len(last.active) == len(kept)
    return kept, remarks


def test_an_effect_that_others_make_needless_is_taken_out(monkeypatch: pytest.MonkeyPatch) -> None:
    kept, remarks = pruned_to(monkeypatch, 121.0)
    assert len(kept) == 1 and kept[0].effect.interval95 == (0.1, 0.5)
    assert "not needed" in remarks[0]


def test_one_without_which_the_fit_is_worse_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    kept, remarks = pruned_to(monkeypatch, 160.0)
    assert len(kept) == 2 and remarks == []
