"""How refits are compared: by what they leave, by how free they were, and by what noise is left."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree
from lit_box import MESH, STATED, within
from standings import VALUES, standing

from thermo.discover import Place
from thermo.discover import _refits as module
from thermo.discover._bench import Bench
from thermo.discover._candidate import Card
from thermo.discover._entries import Active, Entry
from thermo.discover._extended import Extended
from thermo.discover._pace import silent
from thermo.discover._refits import (
    Refit,
    could_reach,
    in_order,
    in_place_of,
    near_best,
    on_same_cells,
    refits,
    worth_a_refit,
)
from thermo.discover._rounds import simplest_first, together
from thermo.discover._scores import Score, ScoreTable
from thermo.discover._standing import Standing
from thermo.discover.candidates import (
    HeaterPower,
    HiddenSource,
    Void,
)
from thermo.inverse import Ready

from .lit_objective import box_task, objective


def refit(name: str, left: float, free: int, smooth: float = 1.0, *, fault: bool = False) -> Refit:
    card = Card(name, "1", 1.0, -np.inf, np.inf, "", "", "", fault=fault)
    score = Score(Entry(0, 0, card, np.array([0])), 5.0, np.ones(1), 0.2, 1.0, 0.3, slice(0, 1))
    return Refit(score, standing(left, free, smooth), standing(left, free, smooth))


def names(made: list[Refit]) -> list[str]:
    return [one.name() for one in made]


def test_a_loss_is_half_the_sum_of_squares_and_the_criterion_counts_what_was_free() -> None:
    ended = standing(50.0, 3).ended
    assert ended.loss() == pytest.approx(25.0)
    assert ended.criterion(1.0) == pytest.approx(50.0 + 6.0)
    assert ended.criterion(5.0) == pytest.approx(10.0 + 6.0)


@pytest.mark.parametrize(("gain", "first"), [(9.0, "few"), (11.0, "many")])
def test_more_that_is_free_has_to_gain_two_an_entry(gain: float, first: str) -> None:
    made = [refit("many", 60.0 - gain, 7), refit("few", 60.0, 2)]
    assert names(in_order(made))[0] == first


def test_where_the_closest_leaves_more_than_noise_gains_count_for_less() -> None:
    # A gain of 30 beats five entries more where the rest is noise, not where it has variance 4.
    assert names(in_order([refit("few", 60.0, 2), refit("many", 30.0, 7)])) == ["many", "few"]
    rough = [refit("few", 60.0, 2, smooth=5.0), refit("many", 30.0, 7, smooth=4.0)]
    assert names(in_order(rough)) == ["few", "many"]


def test_the_first_is_always_measured_anew_and_those_behind_by_little_of_its_gain() -> None:
    before = standing(200.0, 2).ended
    made = [refit("a", 50.0, 3), refit("b", 80.0, 3), refit("c", 120.0, 3), refit("d", 81.0, 3)]
    # Three tenths of the gain of 148 are 44.
    assert names(near_best(before, in_order(made))) == ["a", "b", "d"]
    # The closest may be one that was free to be: what is first by the criterion is near itself.
    worse = in_order([refit("free", 199.0, 30), refit("poor", 199.5, 3)])
    assert names(near_best(before, worse)) == ["poor"]


def test_what_explains_as_much_stays_beside_the_best_however_free_it_was() -> None:
    made = in_order([refit("plain", 50.0, 3), refit("free", 49.9, 13), refit("worse", 70.0, 3)])
    assert names(made) == ["plain", "free", "worse"]
    assert together(made, 1.0, 9.0) == ["plain", "free"]
    assert together(made, 1.0, 21.0) == ["plain", "free", "worse"]
    # Of one that leaves more than the best does but was less free, the criterion decides.
    made = in_order([refit("many", 40.0, 9), refit("few", 50.0, 3)])
    assert names(made) == ["few", "many"] and together(made, 1.0, 9.0) == ["few", "many"]
    made = in_order([refit("many", 30.0, 9), refit("few", 50.0, 3)])
    assert together(made, 1.0, 9.0) == ["many", "few"] and together(made, 1.0, 7.0) == ["many"]


def test_of_those_that_explain_as_much_the_simplest_is_put_to_work() -> None:
    made = in_order([refit("many", 40.0, 6), refit("few", 48.0, 3), refit("least", 90.0, 2)])
    assert names(made) == ["many", "few", "least"]
    assert names(simplest_first(made, 9.0)) == ["few", "many", "least"]
    assert names(simplest_first(made, 1.0)) == ["many", "few", "least"]


def test_at_most_three_are_measured_anew() -> None:
    made = in_order([refit(f"n{number}", 50.0 + number, 3) for number in range(6)])
    assert names(near_best(standing(500.0, 2).ended, made)) == ["n0", "n1", "n2"]


def test_rivals_are_compared_under_the_error_of_cells_where_the_best_stands(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # What each leaves where its own cells' error is measured, and under that of another.
    own = {"best": [48.0, 50.0], "close": [70.0], "far": [90.0]}
    same = {("close", "best"): 41.0, ("far", "best"): 95.0, ("best", "close"): 48.5}
    told: list[str] = []
    rivals: list[float] = []

    def measured(one: Refit, rival: float, *_: object) -> Refit:
        rivals.append(rival)
        return refit(one.name(), own[one.name()].pop(0), 3)

    def on_same_cells(one: Refit, best: Refit) -> Refit:
        told.append(one.name())
        return refit(one.name(), same[one.name(), best.name()], 3)

    monkeypatch.setattr(module, "_once_more", measured)
    monkeypatch.setattr(module, "on_same_cells", on_same_cells)
    made = [refit("best", 60.0, 3), refit("close", 50.0, 3), refit("far", 80.0, 3)]
    order = module._measured_anew(standing(300.0, 2), made, silent())
    assert names(order) == ["close", "best", "far"] and told == ["close", "far", "best"]
    # Each has to reach what those before it left, half of the squares, the best once more.
    assert rivals == pytest.approx([np.inf, 35.0, 24.0, 35.0])
    # Nine squares ahead, and not quite as many where the best stands on the same cells.
    assert together(order, 1.0, 8.0) == ["close", "best"]


@pytest.mark.parametrize(("there", "found"), [(150.0, 45.0), (170.0, 70.0), (400.0, 70.0)])
def test_a_fit_that_measuring_takes_back_is_made_anew_from_its_beginning(
    monkeypatch: pytest.MonkeyPatch, there: float, found: float
) -> None:
    # From 200 to 40 it gained 160 by its own cells: a quarter of that has to be left.
    begun, after = standing(200.0, 3), standing(40.0, 3)
    measured = standing(there, 3)

    def fitted(one: Standing, *, times: int, rival: float) -> Standing:
        assert one is measured and times == 0, "what cells make wrong is known there"
        assert rival == 23.0
        return standing(45.0, 3)

    def in_short_steps(one: Standing, rival: float) -> Standing:
        assert one is begun and rival == 23.0
        return standing(70.0, 3)

    for name, fake in (
        ("remeasured", lambda _: measured), ("fitted", fitted), ("in_short_steps", in_short_steps),
    ):  # fmt: skip
        monkeypatch.setattr(module, name, fake)
    one = Refit(refit("void", 40.0, 3).score, after, begun)
    again = module._once_more(one, 23.0, silent(), 1, 2)
    assert 2 * again.standing.ended.loss() == pytest.approx(found) and again.begun is begun


def test_what_leaves_more_than_nothing_on_its_own_cells_is_no_rival(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # A capacity that falls below zero where the finer run is warmest, as of a real insulation.
    own = {"best": [48.0, 50.0], "burst": [1e9], "far": [90.0]}
    told: list[str] = []

    def on_same_cells(one: Refit, best: Refit) -> Refit:
        told.append(one.name())
        return refit(one.name(), 40.0 if one.name() == "burst" else 95.0, 3)

    monkeypatch.setattr(
        module, "_once_more", lambda one, *_: refit(one.name(), own[one.name()].pop(0), 3)
    )
    monkeypatch.setattr(module, "on_same_cells", on_same_cells)
    made = [refit("best", 60.0, 3), refit("burst", 50.0, 3), refit("far", 80.0, 3)]
    order = module._measured_anew(standing(300.0, 2), made, silent())
    assert names(order) == ["best", "far", "burst"] and told == ["far"]
    # Where none is sound the least is first all the same.
    own |= {"best": [400.0, 410.0], "burst": [1e9], "far": [500.0]}
    order = module._measured_anew(standing(300.0, 2), made, silent())
    assert len(order) == 3 and names(order)[0] == "burst"


@pytest.mark.parametrize(("left", "kept"), [(55.0, 55.0), (75.0, 70.0)])
def test_a_rival_counts_by_the_less_that_it_leaves(
    monkeypatch: pytest.MonkeyPatch, left: float, kept: float
) -> None:
    there = standing(50.0, 3, active=(("a", 0), ("best", 1)))
    best = Refit(refit("best", 50.0, 3).score, there, there)

    def in_place_of(there: Standing, number: int, rival: Refit, most: float) -> Standing:
        assert there is best.standing and (number, rival, most) == (1, one, 0.0)
        return standing(left, 3)

    monkeypatch.setattr(module, "in_place_of", in_place_of)
    one = refit("one", 70.0, 3)
    found = on_same_cells(one, best)
    assert found.name() == "one" and 2 * found.standing.ended.loss() == pytest.approx(kept)


@pytest.mark.parametrize(
    ("sizes", "count"),
    [
        ([9.0, 8.0, 1.5], 2),
        ([9.0, 5.0, 4.9, 4.8, 4.7, 4.6, 4.5], 6),
        ([-9.0, 8.9, 8.8, 8.7, 8.6, 8.5, 8.4, -8.3, 5.0], 8),
        ([], 0),
    ],
)
def test_more_than_a_few_are_refitted_where_scores_are_alike(
    sizes: list[float], count: int
) -> None:
    order = [replace(refit("one", 60.0, 2).score, z=size) for size in sizes]
    assert worth_a_refit(order) == order[:count]


@pytest.mark.parametrize(("left", "first"), [(61.0, "effect"), (90.0, "fault")])
def test_a_fault_that_explains_no_more_stands_behind_an_effect(left: float, first: str) -> None:
    made = [refit("fault", 60.0, 3, fault=True), refit("effect", left, 3), refit("other", 200.0, 3)]
    ordered = simplest_first(made, 9.0)
    assert names(ordered)[0] == first and sorted(names(ordered)) == sorted(names(made))
    assert simplest_first([], 9.0) == []


def test_what_its_score_keeps_from_the_best_is_not_fitted() -> None:
    # A score of 5 promises 12.5: five times that without a place, ten times with one.
    one = refit("some", 60.0, 3).score
    for rival, placed, plain in [(38.0, True, True), (30.0, True, False), (-30.0, False, False)]:
        assert could_reach(one, 100.0, rival, placed=True) is placed
        assert could_reach(one, 100.0, rival, placed=False) is plain
    assert could_reach(one, 100.0, np.inf, placed=False), "the first has no rival"
    assert could_reach(one, 100.0, -30.0, placed=False, far=3.0)
    assert not could_reach(one, 100.0, -100.0, placed=False, far=3.0)


def test_the_search_leaves_what_could_not_reach_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    begun = standing(2 * VALUES, 1)
    kinds = {"best": 12.0, "near": 6.0, "far": 3.5}
    scores = [replace(refit(name, 60.0, 2).score, z=z) for name, z in kinds.items()]
    first = {one.name(): SimpleNamespace(place=None) for one in scores}
    object.__setattr__(begun, "first", first)
    fitted: list[str] = []

    def put_to_work(_: object, score: Score, *__: object) -> Refit:
        fitted.append(score.name())
        return refit(score.name(), 2.0, 2)

    monkeypatch.setattr(module, "_put_to_work", put_to_work)
    monkeypatch.setattr(module, "_measured_anew", lambda _, made, __: made)
    table = ScoreTable(scores, [], 3.0, np.eye(3), np.zeros((VALUES, 3)))
    # Of 80 squares the best leaves 2; a score of 6 might close them all, one of 3.5 only 61.
    assert names(refits(begun, table, (), silent())) == fitted == ["best", "near"]


def test_where_none_closes_half_what_its_score_had_kept_back_is_tried_after_all(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    begun = standing(400.0, 1, smooth=100.0)
    # One of 8 promises 32: five times that is less than the 170 that the best gains.
    scores = [replace(refit(f"n{z:g}", 60.0, 2).score, z=z) for z in (20.0, 8.0)]
    object.__setattr__(begun, "first", {one.name(): SimpleNamespace(place=None) for one in scores})
    tried: list[str] = []

    def put_to_work(_: object, score: Score, *__: object) -> Refit:
        tried.append(score.name())
        return refit(score.name(), 60.0, 2, smooth=60.0)

    monkeypatch.setattr(module, "_put_to_work", put_to_work)
    monkeypatch.setattr(module, "_measured_anew", lambda _, made, __: made)
    table = ScoreTable(scores, [], 3.0, np.eye(2), np.zeros((VALUES, 2)))
    refits(begun, table, (), silent())
    assert tried == ["n20", "n8"] and not could_reach(scores[1], 200.0, 30.0, placed=False)


@pytest.mark.parametrize(
    ("left", "active", "last"),
    [
        (1.0, (), False),  # no more than noise
        (45.0, (), False),  # more than half is closed
        (60.0, (), True),
        (60.0, (("n8", 0),), False),  # beside what was found
    ],
)
def test_where_no_large_score_closes_half_those_behind_are_tried_as_well(
    monkeypatch: pytest.MonkeyPatch, left: float, active: tuple[Active, ...], last: bool
) -> None:
    begun = standing(400.0, 1, smooth=100.0, active=active)
    sizes = [12.0, 7.0, 6.9, 6.8, 6.7, 6.6, 5.9, 5.8]
    scores = [replace(refit(f"n{at}", 60.0, 2).score, z=z) for at, z in enumerate(sizes)]
    places = {one.name(): SimpleNamespace(place=one.name() != "n7" or None) for one in scores}
    object.__setattr__(begun, "first", places)
    tried: list[str] = []

    def put_to_work(_: object, score: Score, *__: object) -> Refit:
        tried.append(score.name())
        return refit(score.name(), 110.0, 2, smooth=left)

    monkeypatch.setattr(module, "_put_to_work", put_to_work)
    monkeypatch.setattr(module, "_measured_anew", lambda _, made, __: made)
    table = ScoreTable(scores, [], 3.0, np.eye(8), np.zeros((VALUES, 8)))
    refits(begun, table, (), silent())
    # Without a place a score of 5.8 would bring five times what it promises, 84, and not 145: no
    # bar where no fit explains enough.
    assert not could_reach(scores[-1], 200.0, 55.0, placed=False)
    assert tried == [f"n{at}" for at in range(6 + 2 * last)]


@pytest.mark.parametrize("known", [True, False])
def test_a_rival_is_put_to_work_where_the_effect_was(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, known: bool
) -> None:
    seen: list[tuple[Standing, float]] = []

    def fitted(there: Standing, *, times: int, rival: float) -> Standing:
        assert times == 0
        seen.append((there, rival))
        return there

    monkeypatch.setattr(module, "fitted", fitted)
    place = Place(jnp.zeros((1, 3)), jnp.ones(1))
    source, void = (
        HiddenSource(jnp.ones(1), place),
        Void(jnp.asarray([0.3]), within((0.0, 0.0, 0.0), 1.0)),
    )
    power = HeaterPower(jnp.zeros(1))
    point = Extended({}, (source, void, power) if known else (source, void))
    bench = Bench(box_task(tmp_path), Ready(MESH, STATED, {}, {}, {}, {}), objective(), MESH)
    made, active = standing(100.0, 4, smooth=2.0), (("hidden_source", 0), ("void", 0))
    here = Standing(bench, {}, point, active, made.ended, made.allowed)
    rival = refit("heater_power", 60.0, 3)
    object.__setattr__(rival.standing, "active", (("heater_power", 0),))
    stands = Extended({}, (replace(power, strength=jnp.asarray([7.0])),))
    object.__setattr__(rival.standing, "point", stands)
    in_place_of(here, 0, rival, 12.0)
    ((there, worst),) = seen
    now = {one.card.name: float(one.strength[0]) for one in there.point.candidates}
    assert now == {"hidden_source": 0.0, "void": pytest.approx(0.3), "heater_power": 7.0}
    assert there.active == (("heater_power", 0), ("void", 0))
    # The loss is 50; what is fitted less by four may leave that much more, times the misfit.
    assert worst == pytest.approx(50.0 + 2 * (12.0 / 2 + 4))


@pytest.mark.parametrize("moved", [0.9, -1.2, 9.0])
@pytest.mark.parametrize("better", [True, False])
def test_where_a_coefficient_was_drawn_far_a_fit_begins_where_the_scene_puts_it_as_well(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, moved: float, better: bool
) -> None:
    bench = Bench(box_task(tmp_path), Ready(MESH, STATED, {}, {}, {}, {}), objective(), MESH)
    power = HeaterPower(jnp.zeros(1))
    first = bench.first(())
    drawn = jax.tree.map(lambda leaf: leaf + moved, first.fields)
    made = standing(100.0, 2)
    here = Standing(bench, {}, Extended(drawn, (power,)), (), made.ended, made.allowed)
    begins: list[float] = []

    def fitted(there: Standing, *, times: int, rival: float) -> Standing:
        assert times == 0 and there.active == (("heater_power", 0),)
        apart = jax.tree.map(lambda one, other: one - other, there.point.fields, first.fields)
        begins.append(float(ravel_pytree(apart)[0].max()))
        # The second is not followed where it cannot leave less than the first.
        assert rival == pytest.approx(70.0 if len(begins) == 1 else 30.0)
        left = 60.0 if len(begins) == 1 else 40.0 if better else 90.0
        return replace(there, ended=standing(left, 3).ended)

    monkeypatch.setattr(module, "fitted", fitted)
    score = replace(refit("some", 60.0, 3).score, entry=Entry(0, 0, power.card, np.array([0])))
    one = module._put_to_work(here, score, (), 70.0)
    far = abs(moved) > 1.1
    assert begins == pytest.approx([moved, 0.0] if far else [moved])
    assert one.standing.ended.loss() == pytest.approx(20.0 if far and better else 30.0)
    at = ravel_pytree(one.begun.point.fields)[0] - ravel_pytree(first.fields)[0]
    np.testing.assert_allclose(at, 0.0 if far and better else moved, atol=1e-12)
