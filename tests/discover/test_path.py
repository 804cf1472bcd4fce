"""The rule by which a search goes on and stops, on rounds made by hand."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from lit_box import MESH, STATED
from standings import VALUES, standing
from verdicts import one_round

from thermo.discover import Calibration, Card, Place, Round, _path
from thermo.discover._bench import Bench
from thermo.discover._entries import Entry
from thermo.discover._pace import Pace, silent
from thermo.discover._path import SearchPath, search, twice
from thermo.discover._refits import Refit
from thermo.discover._scores import Score, ScoreTable
from thermo.discover._standing import Standing
from thermo.discover.candidates import CameraDrift, SupportContact, Void
from thermo.inverse import Ready

from .lit_objective import box_task, objective

PLACE = Place(jnp.zeros((1, 3)), jnp.ones(1))


def found(low: float, high: float, closed: float) -> Round:
    made, chance = one_round(["hidden_source"], closed), 0.2 if low <= 0 <= high else 0.001
    effect = replace(made.effect, interval95=(low, high), chance=chance)
    return replace(made, effect=effect, p_value=chance)


def searched(
    monkeypatch: pytest.MonkeyPatch,
    left: Sequence[float],
    rounds: Sequence[Round],
    alarms: int,
    *,
    place: bool = False,
    slight: bool = False,
    late: bool = False,
    told: Sequence[str] = (),
    doubted: list[Standing] | None = None,
    clear: int = 0,
    asked: list[ScoreTable] | None = None,
    smaller: list[str] | None = None,
    cut: bool = False,
    thin: bool = False,
) -> SearchPath:
    """A search whose standings leave so much, with so many alarms by scores.

    Where the first one is `slight`, or one that comes `late`, it is checked on the next of the
    standings. Rivals are `told` to take places; what is `doubted` is told as well. Beside places
    that leave no misfit, whose tables are `asked`, the first `clear` ones tell of an effect. Where
    cells are made `smaller` is told; they are where they are `cut`; a
    place may be `thin` beside them.
    """
    doubts = [] if doubted is None else doubted
    tables = [] if asked is None else asked
    cells = [] if smaller is None else smaller
    standings = [standing(told + 50.0, 2, smooth=told) for told in left]
    table = ScoreTable([], [], 3.4, np.zeros((0, 0)), np.zeros((0, 0)))
    nothing = replace(table)
    raised = iter([True] * alarms + [False] * 9)
    made, order = iter(rounds), iter(standings[1:])

    def edged(
        now: Standing, rounds: list[Round], before: Standing, most: float, _: Pace
    ) -> tuple[Standing, list[Round]]:
        """Asked of each effect that is no guess."""
        assert before is not now and most == table.threshold**2
        cells.append("edge")
        return now, rounds

    fakes: dict[str, Any] = {
        "scored": lambda *_, **__: table,
        "clear_of_shapes": lambda made, _: (
            tables.append(made) or (made if len(tables) <= clear else nothing)
        ),
        "_alarm": lambda made: made is not nothing and next(raised),
        "_slight": lambda made, _, rough: rough and late is not (made is standings[0]),
        "checked": lambda *_, **__: (next(order), table),
        "refits": lambda *_: [None],
        "put_first": lambda made, _: made,
        "make_round": lambda *_: next(made),
        "with_all": lambda *_: next(order),
        "_out_of_reach": lambda *_: False,
        "placed": lambda made: place and made is not standings[0],
        "with_an_edge": edged,
        "thinnest": lambda _: 0.9 if thin else 1.1,
        "edge_of": lambda _: 1.0,
        "on_small_cells": lambda made, rounds, *_: (
            cells.append("smaller") or (copy(made) if cut else made),
            rounds,
        ),
        "with_doubt": lambda made, _: doubts.append(made) or copy(made),
        "rivals_of": lambda *_: {("one", 0): []},
        "replaced": lambda made, rounds, rivals, most, _: (
            made,
            rounds,
            list(told) if rivals and most == table.threshold**2 else [],
        ),
        "undoubted": lambda made, _: made,
        "by_fine_slopes": lambda last, doubted, _: (last, doubted),
        "with_joint_effects": lambda rounds, *_: rounds,
        "calibrated": lambda *_: Calibration(np.ones(9), 0.04, 0.01, 0.05),
    }
    for name, fake in fakes.items():
        monkeypatch.setattr(_path, name, fake)
    return search(standings[0], (), silent(), rough=slight)


def test_an_effect_that_may_be_nothing_is_not_named_where_nothing_else_is_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = searched(monkeypatch, [1.0], [found(0.0, 0.5, 0.1)], alarms=1)
    assert path.word == "no_gap" and path.rounds == []
    assert "hidden_source passes the threshold" in path.remarks[0]
    assert "[0, 0.5] W" in path.remarks[0]


def test_one_whose_place_makes_up_for_its_strength_is_named_for_what_it_explains(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    flank = replace(found(0.0, 0.5, 0.9), p_value=1e-6)
    path = searched(monkeypatch, [1.5, 1.0], [flank], alarms=1)
    assert path.word == "named" and len(path.rounds) == 1 and path.remarks == []


@pytest.mark.parametrize("low", [-0.1, 0.1])
def test_effects_that_make_up_for_each_other_are_not_named(
    monkeypatch: pytest.MonkeyPatch, low: float
) -> None:
    rounds = [found(low, 0.5, 0.9), found(-1.0, 1.0, 0.9)]
    path = searched(monkeypatch, [5000.0, 500.0, 1.0], rounds, alarms=2)
    told = "Together hidden_source, hidden_source meet the readings, but each of them"
    assert len(path.rounds) == 2
    assert (path.word, any(told in one for one in path.remarks)) == (
        ("named", False) if low > 0 else ("none_of_mine", True)
    )


def test_kinds_at_two_places_are_told_of() -> None:
    (told,) = twice(["void", "local_convection", "void"])
    assert told.startswith("void is at work at 2 places")
    assert twice([]) == twice(["void", "sensor_lag"]) == []


def test_one_that_cannot_be_nothing_is(monkeypatch: pytest.MonkeyPatch) -> None:
    path = searched(monkeypatch, [1.5, 1.0], [found(0.1, 0.5, 0.9)], alarms=1)
    assert path.word == "named" and len(path.rounds) == 1 and path.remarks == []


@pytest.mark.parametrize("told", [[], ["one took the place of another"]])
def test_a_rival_that_took_a_place_is_told_and_its_shape_is_doubted(
    monkeypatch: pytest.MonkeyPatch, told: list[str]
) -> None:
    doubted: list[Standing] = []
    made = [found(0.1, 0.5, 0.9)]
    path = searched(monkeypatch, [1.5, 1.0], made, alarms=1, told=told, doubted=doubted)
    assert path.remarks == told and len(doubted) == 1 + len(told)
    # What nothing came after is taken as it was fitted before the last doubt.
    assert path.standing is doubted[-1]


def test_a_gap_in_smooth_shapes_is_not_argued_away(monkeypatch: pytest.MonkeyPatch) -> None:
    path = searched(monkeypatch, [5000.0, 1.0], [found(-0.1, 0.5, 0.9)], alarms=1)
    assert path.word == "named" and len(path.rounds) == 1


def test_a_second_effect_that_may_be_nothing_ends_the_search(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rounds = [found(0.1, 0.5, 0.9), found(-1.0, 1.0, 0.9)]
    path = searched(monkeypatch, [5000.0, 1.5], rounds, alarms=2)
    assert path.word == "named" and len(path.rounds) == 1 and len(path.remarks) == 1


@pytest.mark.parametrize(
    ("left", "clear", "count"), [(1.5, 0, 1), (1.5, 1, 2), (1.5, 2, 3), (500.0, 0, 3)]
)
def test_beside_a_place_that_leaves_no_misfit_only_what_is_clear_of_it_is_looked_at(
    monkeypatch: pytest.MonkeyPatch, left: float, clear: int, count: int
) -> None:
    rounds = [found(0.1, 0.5, 0.9), found(0.2, 0.3, 0.9), found(0.3, 0.4, 0.9)]
    asked: list[ScoreTable] = []
    more = {"place": True, "clear": clear, "asked": asked}
    path = searched(monkeypatch, [5000.0, left, left, 1.0], rounds, alarms=9, **more)
    assert path.word == "named" and len(path.rounds) == count
    # Where shapes are quiet beside a place, and there alone.
    assert len(asked) == (0 if left > 100 else min(count, 2))
    assert ("Nothing more was looked for" in "".join(path.remarks)) is (count < 3)


@pytest.mark.parametrize(
    ("first", "second", "left", "word", "count"),
    [
        (0.3, 0.95, 1.0, "named", 2),
        (0.3, 0.3, 3000.0, "none_of_mine", 1),
        (0.2, 0.95, 3000.0, "none_of_mine", 1),
    ],
)
def test_of_two_that_show_alike_the_first_may_close_less_than_half(
    monkeypatch: pytest.MonkeyPatch, first: float, second: float, left: float, word: str, count: int
) -> None:
    rounds = [found(0.1, 0.5, first), found(0.2, 0.3, second)]
    path = searched(monkeypatch, [5000.0, 3500.0, left], rounds, alarms=2)
    assert (path.word, len(path.rounds)) == (word, count)


def test_two_that_do_not_close_nine_tenths_are_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    rounds = [found(0.1, 0.5, 0.4), found(0.2, 0.3, 0.7), found(0.2, 0.3, 0.9)]
    smaller: list[str] = []
    left = [5000.0, 3000.0, 900.0, 1.0]
    path = searched(monkeypatch, left, rounds, alarms=3, smaller=smaller)
    assert path.word == "none_of_mine" and len(path.rounds) == 2 and smaller == []
    assert "with a second one 82 % of it are closed" in path.remarks[0]
    # Had the first closed half of it, a third would have been looked for.
    rounds[0] = found(0.1, 0.5, 0.6)
    path = searched(monkeypatch, left, rounds, alarms=3, smaller=smaller)
    assert path.word == "named" and len(path.rounds) == 3
    assert smaller == ["edge", "smaller"] * 3
    # What no place told on large cells is asked once more where these were made smaller.
    smaller.clear()
    searched(monkeypatch, [5000.0, 1.0], [found(0.1, 0.5, 0.9)], 1, smaller=smaller, cut=True)
    assert smaller == ["edge", "smaller", "edge"]
    smaller.clear()
    searched(monkeypatch, [5000.0, 1.0], [found(0.1, 0.5, 0.9)], 1, smaller=smaller, thin=True)
    assert smaller == ["smaller", "edge"]


def test_a_fault_of_the_record_is_told_of_and_not_named(monkeypatch: pytest.MonkeyPatch) -> None:
    drift = found(0.001, 0.003, 0.99)
    drift = replace(drift, effect=replace(drift.effect, card=CameraDrift.card, strength=0.002))
    path = searched(monkeypatch, [5000.0], [drift], alarms=1)
    assert path.word == "none_of_mine" and path.rounds == []
    assert "camera_drift of 0.002 K/s" in path.remarks[0] and "known temperature" in path.remarks[0]


def test_a_slight_alarm_is_checked_before_anything_is_refitted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = searched(monkeypatch, [1.5, 1.0], [], alarms=0, slight=True)
    assert path.word == "no_gap" and path.begun is path.standing
    assert path.begun.gap()[0] == pytest.approx(1.0), "where it was checked, not where it began"
    rounds = [found(0.1, 0.5, 0.9)]
    path = searched(monkeypatch, [1.5, 1.4, 1.0], rounds, alarms=1, slight=True)
    assert path.word == "named" and path.begun.gap()[0] == pytest.approx(1.4)


def test_a_later_alarm_is_checked_beside_what_was_found(monkeypatch: pytest.MonkeyPatch) -> None:
    left, made = [5000.0, 1.5, 1.0], [found(0.1, 0.5, 0.99)]
    path = searched(monkeypatch, left, made, alarms=1, slight=True, late=True)
    assert path.word == "named" and len(path.rounds) == 1
    assert path.begun.gap()[0] == pytest.approx(5000.0), "where nothing was at work"
    assert path.standing.gap()[0] == pytest.approx(1.0), "on the smaller cells"


@pytest.mark.parametrize(
    ("z", "smooth", "slight"),
    [(3.0, 1.0, False), (3.0, 40.0, True), (3.5, 1.0, True), (10.1, 1.0, True), (10.3, 1.0, False)],
)
def test_an_alarm_is_slight_where_cells_could_raise_it(
    z: float, smooth: float, slight: bool
) -> None:
    # The threshold is 3.4.
    made = standing(60.0, 2, smooth=smooth)
    assert _path._slight(made, table_of(z), rough=False) is slight
    # Where cells make more wrong than noise does they could raise any.
    assert _path._slight(made, table_of(z), rough=True) is (slight or z > 3.4)
    # A score to the side on which its strength cannot be raises none.
    other = beside(table_of(z), table_of(-50.0, Void.card))
    assert _path._slight(made, other, rough=False) is slight


@pytest.mark.parametrize("z", [3.0, 5.0])
def test_what_only_cells_raise_is_told(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, z: float
) -> None:
    usual = Bench(box_task(tmp_path), Ready(MESH, STATED, {}, {}, {}, {}), objective(), MESH)
    smaller = replace(usual)
    made = standing(60.0, 2)
    began = Standing(usual, {}, made.point, (), made.ended, made.allowed)
    measured: list[int] = []

    def refined(before: Standing, bench: Bench, *, rough: bool) -> Standing:
        assert bench is smaller and before.bench is usual
        measured.append(1)
        return replace(before, bench=replace(bench, scatter=1.73) if rough else bench)

    monkeypatch.setattr(_path, "finest", lambda _: smaller)
    monkeypatch.setattr(_path, "refined", refined)
    monkeypatch.setattr(_path, "scored", lambda *_, **__: table_of(z))
    remarks: list[str] = []
    # A score to the side on which its strength cannot be raises no alarm, however large.
    before = beside(table_of(4.2), table_of(-9.0, Void.card))
    last, anew = _path.checked(began, began, 1.0, (), before, silent(), remarks, rough=False)
    assert measured == [1] and last.bench is smaller and anew.scores[0].z == z
    assert (remarks == []) is (z > 3.4)
    assert all("4.2 passed the threshold" in one for one in remarks)
    scattered: list[str] = []
    _path.checked(began, began, 1.0, (), before, silent(), scattered, rough=True)
    assert "scatter 1.7 times as far" in scattered[0] and scattered[1:] == remarks
    there = replace(began, bench=replace(usual, ready=replace(usual.ready, grids={})))
    same = _path.checked(began, there, 1.0, (), before, silent(), [], rough=False)
    assert same == (began, before), "on another mesh than where it began"
    monkeypatch.setattr(_path, "finest", lambda bench: bench)
    same = _path.checked(began, began, 1.0, (), before, silent(), [], rough=False)
    assert same == (began, before), "no smaller cells"


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
    last, kept = _path.pruned(now, rounds, 9.0, silent(), remarks)
    assert len(last.active) == len(kept)
    return kept, remarks


def test_an_effect_that_others_make_needless_is_taken_out(monkeypatch: pytest.MonkeyPatch) -> None:
    kept, remarks = pruned_to(monkeypatch, 121.0)
    assert len(kept) == 1 and kept[0].effect.interval95 == (0.1, 0.5)
    assert "not needed" in remarks[0]


def test_one_without_which_the_fit_is_worse_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    kept, remarks = pruned_to(monkeypatch, 160.0)
    assert len(kept) == 2 and remarks == []


def beside(one: ScoreTable, other: ScoreTable) -> ScoreTable:
    return replace(one, scores=one.scores + other.scores)


def table_of(z: float, card: Card = CameraDrift.card) -> ScoreTable:
    one = Score(Entry(0, 0, card, np.array([0])), z, np.ones(1), 0.2, 1.0, 0.3, slice(0, 1))
    return ScoreTable([one], [], 3.4, np.eye(1), np.zeros((VALUES, 1)))


def test_the_largest_score_that_is_not_followed_is_told_in_thresholds() -> None:
    # The largest of all is to a side on which its strength cannot be.
    left_aside = beside(table_of(4.42), table_of(-9.0, Void.card))
    told = _path._fine(replace(table_of(0.0), scores=[], unfollowed=left_aside.scores))
    assert "scores 2 thresholds or more: the largest, camera_drift, 1.3. Nothing more" in told
    assert "or more. Nothing more was" in _path._fine(replace(table_of(0.0), scores=[]))


@pytest.mark.parametrize(
    ("left", "z", "far"),
    [(VALUES * 5.0, 5.0, True), (VALUES * 5.0, -7.0, False), (VALUES * 1.04, 0.1, False)],
)
def test_what_no_score_reaches_is_not_refitted(left: float, z: float, far: bool) -> None:
    # Of 160 beyond noise a score of 7 shows 49, and one of 5 no more than 25.
    assert _path._out_of_reach(standing(left, 2), table_of(z)) is far


@pytest.mark.parametrize("left", [61.0, np.inf])
def test_the_simplest_is_put_first_unless_fine_cells_cannot_take_it(
    monkeypatch: pytest.MonkeyPatch, left: float
) -> None:
    entry = Entry(0, 0, Void.card, np.array([0]))
    score = Score(entry, 5.0, np.ones(1), 0.2, 1.0, 0.3, slice(0, 1))
    best, simple = (Refit(score, standing(told, 1), standing(80.0, 0)) for told in (60.0, 62.0))
    measured = standing(50.0, 1)
    residual = np.full_like(measured.ended.residual, left)
    measured = replace(measured, ended=replace(measured.ended, residual=residual))
    monkeypatch.setattr(_path, "simplest_first", lambda *_: [simple, best])
    monkeypatch.setattr(_path, "fitted", lambda *_, **__: measured)
    found = _path.put_first([best, simple], 12.0)
    if np.isfinite(left):
        assert found[0].standing is measured and found[1] is best
    else:
        assert found == [best]


def test_what_is_put_to_work_is_told_with_its_strength_and_place() -> None:
    told: list[str] = []
    one = one_round(["hidden_source", "sensor_lag"], 0.9)
    _path._told(one, Pace(told.append))
    assert told[-1].startswith("put to work: hidden_source 1.25 W at (10.0, 0.0, 4.0) mm or sensor")
    side = replace(one, effect=replace(one.effect, card=SupportContact.card, side="-z"))
    _path._told(side, Pace(told.append))
    assert "support_contact 1.25 W/m2/K at -z or hidden_source or sensor_lag; lamp " in told[-1]
