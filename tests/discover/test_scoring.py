"""What is scored where a search stands."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import pytest
from standings import standing

from thermo.discover import Place, Transition, _scoring
from thermo.discover._bench import Bench
from thermo.discover._extended import Extended
from thermo.discover._scoring import scored
from thermo.discover.candidates import HiddenSource, LatentHeat, TemperatureDependentConductivity


def test_where_all_there_is_stands_at_work_nothing_is_scored() -> None:
    found = scored(standing(60.0, 2), (), alpha=0.04)
    assert found.scores == [] and found.unseen == [] and found.threshold > 2
    # Where cells scatter scores as well, they have to be as much larger.
    rough = standing(60.0, 2)
    object.__setattr__(rough.bench, "scatter", 1.5)
    assert scored(rough, (), alpha=0.04).threshold == pytest.approx(1.5 * found.threshold)


def test_laws_are_put_beside_all_kinds_whatever_is_at_work() -> None:
    source = HiddenSource(jnp.zeros(3), Place(jnp.zeros((3, 3)), jnp.ones(3)))
    law = TemperatureDependentConductivity(jnp.zeros(1))
    bells = Transition(jnp.array([300.0, 320.0, 340.0]), jnp.full(3, 5.0))
    phases = LatentHeat(jnp.zeros(3), bells, jnp.asarray(1e3))
    shapes = []
    for active in ((), (("hidden_source", 2),)):
        one = standing(60.0, 2, active=active)
        for name, value in {
            "point": Extended({}, (source,)),
            "first": {"hidden_source": source, law.card.name: law, phases.card.name: phases},
            "bench": object.__new__(Bench),
        }.items():
            object.__setattr__(one, name, value)
        beside, found = _scoring._law_entries(one, (law, phases))
        # Every transition is scored: one elsewhere may hardly show in what was read.
        scored_there = [(law.card.name, 0), *((phases.card.name, part) for part in range(3))]
        assert [(each.card.name, each.part) for each in found] == scored_there
        shapes.append([leaf.shape for leaf in jax.tree.leaves(beside)])
    assert shapes[0] == shapes[1], "another shape would be another program"


def test_a_table_makes_room_for_its_program(monkeypatch: pytest.MonkeyPatch) -> None:
    # Without it a long search came to what the system allows a process, and was aborted.
    class AskedFor(Exception):
        pass

    def make_room() -> None:
        raise AskedFor

    monkeypatch.setattr(_scoring, "make_room", make_room)
    with pytest.raises(AskedFor):
        scored(standing(60.0, 2), (), alpha=0.04)
