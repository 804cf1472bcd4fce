"""How alike two effects are, against angles that are known."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.discover._aliases import aliases
from thermo.discover._candidate import Card
from thermo.discover._entries import Entry
from thermo.discover._projection import projection
from thermo.discover._scores import score_table

VALUES = 40


def card(name: str, *, joint: bool = False) -> Card:
    return Card(name, "1", 1.0, -np.inf, np.inf, "", "", "", joint=joint)


def found_alike(signatures: np.ndarray, entries: list[Entry], free: np.ndarray) -> dict:
    residual = np.random.default_rng(5).normal(size=VALUES)
    return dict(aliases(score_table(entries, signatures, residual, projection(free), alpha=0.05)))


def test_it_is_the_cosine_of_what_the_unknowns_leave() -> None:
    make = np.random.default_rng(1)
    free, both = make.normal(size=(VALUES, 2)), 4 * make.normal(size=(VALUES, 2))
    entries = [Entry(0, 0, card("one"), np.array([0])), Entry(1, 0, card("other"), np.array([1]))]
    found = found_alike(both, entries, free)
    one, other = (projection(free).left(both)).T
    wanted = abs(one @ other) / np.linalg.norm(one) / np.linalg.norm(other)
    assert found["one"]["other"] == pytest.approx(wanted)
    assert found["other"]["one"] == pytest.approx(wanted)
    assert found["one"]["one"] == found["other"]["other"] == 1.0


def test_a_history_that_can_be_like_an_effect_is_its_alias() -> None:
    make = np.random.default_rng(2)
    history = 4 * make.normal(size=(VALUES, 3))
    like, unlike = history @ [1.0, -2.0, 0.5], make.normal(size=VALUES)
    unlike -= history @ np.linalg.lstsq(history, unlike, rcond=None)[0]
    entries = [
        Entry(0, 0, card("history", joint=True), np.array([0, 1, 2])),
        Entry(1, 0, card("like"), np.array([3])),
        Entry(2, 0, card("unlike"), np.array([4])),
    ]
    signatures = np.column_stack([history, like, 4 * unlike])
    found = found_alike(signatures, entries, np.zeros((VALUES, 0)))
    assert found["history"]["like"] == pytest.approx(1.0, abs=1e-6)
    assert found["history"]["unlike"] == pytest.approx(0.0, abs=1e-6)


def test_of_a_kind_with_places_the_best_place_counts() -> None:
    make = np.random.default_rng(3)
    other = 4 * make.normal(size=VALUES)
    residual = np.random.default_rng(5).normal(size=VALUES)
    # The second place is along what is left, so that its score is the largest there can be.
    places = np.column_stack([other, 4 * residual])
    entries = [Entry(0, part, card("place"), np.array([part])) for part in range(2)]
    entries.append(Entry(1, 0, card("other"), np.array([2])))
    found = found_alike(np.column_stack([places, other]), entries, np.zeros((VALUES, 0)))
    wanted = abs(other @ residual) / np.linalg.norm(other) / np.linalg.norm(residual)
    assert found["place"]["other"] == pytest.approx(wanted)
    assert list(found) == ["place", "other"], "the largest score first"
