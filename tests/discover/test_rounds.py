"""Rounds in numbers: each begins with what the one before has left."""

from __future__ import annotations

from dataclasses import replace

import pytest
from standings import standing
from verdicts import one_round

from thermo.discover import _rounds
from thermo.discover._rounds import with_joint_effects


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
