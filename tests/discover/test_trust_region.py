"""Steps on cells that are right only near where they were measured, of a toy of one entry."""

from __future__ import annotations

import sys
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree
from standings import standing

from thermo.discover import _trust_region as module
from thermo.discover._bench import Bench
from thermo.discover._descent import Ended, Free
from thermo.discover._extended import Extended
from thermo.discover._standing import Standing, lost
from thermo.discover._trust_region import in_short_steps, kept_promise, remeasured

TRUE, SLOPE = 3.0, 10.0
FREE = Free(np.array([0]), np.ones(1), np.full(1, -20.0), np.full(1, 20.0), np.zeros(1, bool))


class Toy:
    """Fine cells read x; coarse ones `share` of a change from where they were measured last."""

    def __init__(self, share: float, monkeypatch: pytest.MonkeyPatch) -> None:
        self.share, self.tried = share, [0.0]
        bench = object.__new__(Bench)
        self.at = {id(bench): 0.0}
        self.benches = [bench]
        first = standing(60.0, 1)
        ended = Ended(point(0.0), np.zeros(1), np.ones((1, 1)))
        self.begun = Standing(bench, {}, point(0.0), (), ended, first.allowed)
        for name, fake in {
            "with_few_places": lambda one: (one, {}), "free_of": lambda _: FREE,
            "with_all_places": lambda _, small, __: small, "measured": self.measured,
            "not_moved": self.not_moved, "descended": self.descended,
        }.items():  # fmt: skip
            monkeypatch.setattr(module, name, fake)

    def measured(self, one: Standing) -> Standing:
        bench = object.__new__(Bench)
        self.benches.append(bench)  # So that no other takes its number.
        self.at[id(bench)] = place(one)
        self.tried.append(place(one))
        return replace(one, bench=bench)

    def left(self, one: Standing, at: float) -> Standing:
        base = self.at[id(one.bench)]
        residual = np.array([SLOPE * (base + self.share * (at - base) - TRUE)])
        ended = Ended(point(at), residual, np.ones((1, 1)))
        return replace(one, point=ended.point, ended=ended)

    def not_moved(self, one: Standing, _: Free) -> Standing:
        return self.left(one, place(one))

    def descended(self, one: Standing, free: Free) -> Standing:
        base = self.at[id(one.bench)]
        wanted = base + (TRUE - base) / self.share
        return self.left(one, float(np.clip(wanted, free.low[0], free.high[0])))


def point(at: float) -> Extended:
    return Extended({"x": {"value": jnp.asarray([at])}}, ())  # type: ignore[dict-item]


def place(one: Standing) -> float:
    return float(np.asarray(ravel_pytree(one.point)[0])[0])


def test_a_gain_that_measuring_takes_back_is_no_kept_promise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for share, kept in ((1.0, True), (0.8, True), (0.3, False)):
        toy = Toy(share, monkeypatch)
        begun = toy.not_moved(toy.begun, FREE)
        after = toy.descended(begun, FREE)
        there = toy.not_moved(toy.measured(after), FREE)
        assert kept_promise(begun, after, there) == kept


@pytest.mark.parametrize("share", [0.3, 0.6, 1.0, 1.7])
def test_short_steps_arrive_where_one_long_step_goes_astray(
    monkeypatch: pytest.MonkeyPatch, share: float
) -> None:
    toy = Toy(share, monkeypatch)
    found = in_short_steps(toy.begun)
    assert place(found) == pytest.approx(TRUE, abs=0.35)
    # What is left is told by cells measured there, and is never more than at a place tried before.
    assert toy.at[id(found.bench)] == place(found)
    fine = [0.5 * (SLOPE * (at - TRUE)) ** 2 for at in toy.tried]
    assert found.ended.loss() == pytest.approx(min(fine))
    assert len(fine) <= 11


def test_what_promises_nothing_is_not_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    toy = Toy(1.0, monkeypatch)
    toy.at[id(toy.benches[0])] = TRUE
    toy.begun = replace(toy.begun, point=point(TRUE))
    assert in_short_steps(toy.begun).bench is toy.begun.bench and toy.tried == [0.0]


def test_one_that_will_not_reach_its_rival_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    # Steps are twice as long each, and the least is a thousand of the first away: three of them
    # gain 1.7e5 of 1.25e7, the last of which 1e5, of which seven more are left.
    monkeypatch.setattr(sys.modules[__name__], "TRUE", 500.0)
    for rival, wanted in ((1.0e7, 4), (1.2e7, 7)):
        toy = Toy(1.0, monkeypatch)
        found = in_short_steps(toy.begun, rival)
        assert len(toy.tried) == wanted
        assert place(found) == toy.tried[-1] == {4: 3.5, 7: 20.0}[wanted]


def test_where_fine_cells_burst_it_turns_back(monkeypatch: pytest.MonkeyPatch) -> None:
    toy = Toy(0.3, monkeypatch)

    def measured(one: Standing) -> Standing:
        if place(one) <= 2.0:
            return toy.measured(one)
        return replace(one, ended=replace(one.ended, residual=np.array([np.inf])))

    monkeypatch.setattr(module, "measured", measured)
    monkeypatch.setattr(
        module, "not_moved", lambda one, free: one if lost(one) else toy.not_moved(one, free)
    )
    begun = toy.not_moved(toy.begun, FREE)
    far = toy.descended(begun, FREE)
    assert place(far) > 2.0 and not kept_promise(begun, far, remeasured(far))
    found = in_short_steps(toy.begun)
    assert 1.0 < place(found) <= 2.0 and np.isfinite(found.ended.loss())
