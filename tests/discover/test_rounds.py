"""Rounds in numbers: each begins with what the one before has left."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from lit_box import SIZE, at
from standings import VALUES, standing
from verdicts import SOURCE, one_round

from thermo.discover import _rounds
from thermo.discover._entries import Entry
from thermo.discover._refits import Refit
from thermo.discover._rounds import effect_of, evidence, make_round, with_joint_effects
from thermo.discover._scores import Score, ScoreTable
from thermo.discover._standing import free_of
from thermo.discover.candidates import AnisotropicConductivity, HiddenSource, SensorLag

from .lit_objective import objective, standing_at


@pytest.mark.parametrize(("parts", "chance"), [(1, 0.0455), (10, 0.455), (100, 1.0)])
def test_noise_explains_as_much_by_any_of_what_was_scored(
    monkeypatch: pytest.MonkeyPatch, parts: int, chance: float
) -> None:
    for name, fake in [
        ("effect_of", one_round([], 0.9).effect), ("rms", {}), ("candidacies", []),
        ("evidence", {}),
    ]:  # fmt: skip
        monkeypatch.setattr(_rounds, name, lambda *_, fake=fake: fake)
    score = Score(Entry(0, 0, SOURCE, np.zeros(1, int)), 2.0, np.zeros(1), 1.0, 1.0, 0.5, slice(1))
    table = ScoreTable([score] * parts, [], 3.4, np.zeros((0, 0)), np.zeros((0, 0)))
    before, after = standing(44.0, 2), standing(40.0, 3, active=(("hidden_source", 0),))
    made = make_round(before, [Refit(score, after, before)], table)
    # Four of chi-square with one free entry more: 4.55 %.
    assert made.p_value == pytest.approx(chance, rel=1e-3)


def test_what_explains_as_much_is_told_as_it_was_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    effect = one_round([], 0.9).effect
    monkeypatch.setattr(_rounds, "candidacies", lambda *_: [])
    monkeypatch.setattr(_rounds, "rms", lambda one: {"lamp": one.ended.loss()})
    monkeypatch.setattr(
        _rounds,
        "effect_of",
        lambda one, active, _: replace(effect, strength=one.ended.loss(), side=active[0]),
    )
    monkeypatch.setattr(_rounds, "values", lambda one, _: {"conductivity": 10 * one.ended.loss()})
    monkeypatch.setattr(_rounds, "parameter_intervals", lambda _: {"conductivity": (1.0, 2.0)})
    made = []
    for name, left in (("first", 40.0), ("near", 44.0), ("far", 90.0)):
        entry = Entry(0, 0, replace(SOURCE, name=name), np.zeros(1, int))
        score = Score(entry, 2.0, np.zeros(1), 1.0, 1.0, 0.5, slice(1))
        made.append(Refit(score, standing(left, 3, active=((name, 0),)), standing(200.0, 2)))
    table = ScoreTable([made[0].score], [], 3.4, np.zeros((0, 0)), np.zeros((0, 0)))
    one = make_round(standing(200.0, 2), made, table)
    assert one.together == ["first", "near"] and list(one.alternatives) == ["near"]
    near = one.alternatives["near"]
    assert near.effect.strength == pytest.approx(22.0) and near.effect.side == "near"
    assert near.rms == {"lamp": pytest.approx(22.0)}
    assert near.parameters == {"conductivity": (pytest.approx(220.0), (1.0, 2.0))}


@pytest.mark.parametrize("count", range(4))
def test_rounds_go_on_from_what_was_left_and_end_with_the_last_fit(
    monkeypatch: pytest.MonkeyPatch, count: int
) -> None:
    active = tuple(("hidden_source", part) for part in range(count))
    last = standing(2.0, 2, active=active)
    effect = one_round([], 0.9).effect
    monkeypatch.setattr(_rounds, "rms", lambda one: {"lamp": 0.05 if one is last else 1.0})
    monkeypatch.setattr(
        _rounds, "effect_of", lambda _, active, *__: replace(effect, strength=float(active[1]))
    )
    rounds = [
        replace(one_round([], 0.9), rms_before={"lamp": before}, rms_after={"lamp": after})
        for before, after in [(0.9, 0.4), (0.6, 0.5), (0.7, 0.7)]
    ]
    made = with_joint_effects(rounds[:count], last, standing(3.0, 2))
    ends = [0.9, 0.4, 0.5][:count] + [0.05][:count]
    assert [one.rms_before["lamp"] for one in made] == ends[:-1]
    assert [one.rms_after["lamp"] for one in made] == ends[1:]
    assert [one.effect.strength for one in made] == list(range(count))


def test_evidence_pays_the_logarithm_of_the_readings_for_each_that_is_free() -> None:
    before = standing(100.0, 2).ended
    found = evidence(before, {"few": standing(90.0, 3).ended, "many": standing(90.0, 6).ended})
    assert found["few"] == pytest.approx(-10.0 + np.log(VALUES))
    assert found["many"] - found["few"] == pytest.approx(3 * np.log(VALUES))


@pytest.mark.parametrize(("middle", "told"), [(-0.3, 0.0), (0.4, 0.4)])
def test_the_place_of_an_effect_is_one_of_the_body(middle: float, told: float) -> None:
    where = np.array([middle, 0.5, 0.5]) * SIZE
    made = standing_at(objective(), HiddenSource(jnp.ones(1), at(tuple(where), 0.003)))
    slopes = np.eye(len(made.ended.residual), len(free_of(made).number))
    effect = effect_of(replace(made, ended=replace(made.ended, slopes=slopes)), made.active[0], 1.0)
    assert effect.centre == pytest.approx(np.array([told, 0.5, 0.5]) * SIZE)
    assert effect.size == pytest.approx(0.003)


def test_an_effect_along_an_axis_says_which() -> None:
    made = standing_at(objective(), AnisotropicConductivity(jnp.asarray([0.0, 0.0, 0.4])))
    made = replace(made, active=(("anisotropic_conductivity", 2),))
    slopes = np.eye(len(made.ended.residual), len(free_of(made).number))
    made = replace(made, ended=replace(made.ended, slopes=slopes))
    effect = effect_of(made, made.active[0], 1.0)
    assert (effect.part, effect.strength) == ("along z", pytest.approx(0.4))
    # Parts without a name of their own have none.
    lag = standing_at(objective(), SensorLag(jnp.ones(1)))
    lag = replace(lag, ended=replace(lag.ended, slopes=slopes))
    assert effect_of(lag, lag.active[0], 1.0).part is None
