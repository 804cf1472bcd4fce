"""Which stages a fit has, and when the data choose the smoothness."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest

from thermo.errors import InputError
from thermo.inverse import (
    Adam,
    LevenbergMarquardt,
    Meshing,
    Network,
    OnControlPoints,
    Patchwise,
    Prior,
    Stepping,
    TwoMaterials,
    Uniform,
)
from thermo.inverse._objective import SETTLED, Objective
from thermo.inverse._stages import (
    ASKED,
    NEAR_EARLY,
    SETTLED_EARLY,
    data_choose,
    make_stage,
    stage_orders,
)
from thermo.inverse._task import Ready, Task, prepare
from thermo.observe import Scene, read_scene
from thermo.physics.integrators import BackwardEuler

from .conftest import START

pytestmark = pytest.mark.usefixtures("bricks")

POINTS = OnControlPoints(count=4)


@pytest.fixture(scope="module")
def task(block: Path, meshing: Meshing) -> Task:
    scene: Scene = read_scene(block)
    stepping = Stepping(integrator=BackwardEuler(), size=3.0)
    cells = replace(meshing, order=2, corrected=True)
    how = (POINTS, LevenbergMarquardt(), Prior(), stepping, cells)
    return Task(scene, (scene.runs["lamp"],), ("conductivity",), *how, "tet4_tet10", START, 0, 0.01)


@pytest.fixture(scope="module")
def ready(task: Task) -> Ready:
    return prepare(task)


@pytest.mark.parametrize(
    ("change", "asked", "orders"),
    [
        ({}, True, (1, 2, 2, *(2,) * ASKED)),
        ({"stages": "none"}, True, (2, 2, *(2,) * ASKED)),
        ({"choice": Patchwise(patches=3)}, True, (1, 2, 2, *(2,) * ASKED)),
        ({"meshing": Meshing(order=1, corrected=False)}, True, (1, *(1,) * ASKED)),
        ({"prior": Prior(step=0.3)}, False, (1, 2, 2)),
        ({"prior": Prior(step=0.3), "stages": "none"}, False, (2, 2)),
        ({"optimiser": Adam()}, False, (1, 2)),
        ({"choice": Uniform()}, False, (1, 2, 2)),
        ({"choice": Uniform(), "meshing": Meshing(corrected=False)}, False, (1, 2)),
        ({"choice": TwoMaterials(count=6)}, False, (1, 2, 2)),
        ({"choice": TwoMaterials(count=6), "stages": "none"}, False, (2, 2, 2)),
        ({"choice": Network(count=4, width=32)}, False, (1, 2, 2)),
    ],
)
def test_the_stages_of_a_fit(
    change: dict[str, Any], asked: bool, orders: tuple[int, ...], task: Task
) -> None:
    other = replace(task, **change)
    ready = prepare(other)
    assert data_choose(other, ready) is asked
    assert stage_orders(other, ready) == orders


def stages(task: Task, ready: Ready) -> Iterator[Objective]:
    """Each stage from where the one before began, until nothing is left to do."""
    before = None
    for number in range(len(stage_orders(task, ready))):
        before = make_stage(task, ready, number, before)
        if before is None:
            return
        yield before


def test_one_value_comes_first_and_the_field_begins_with_it(task: Task, ready: Ready) -> None:
    first = make_stage(task, ready, 0, None)
    assert first is not None
    field = first.fields["conductivity"]
    assert np.shape(field.parameters()) == (1,)
    assert float(field.control_values()[0]) == pytest.approx(START["conductivity"])
    assert np.shape(first.space.mesh.cells)[1] == 4
    moved = replace(first, fields={"conductivity": field.with_parameters(field.parameters() + 0.5)})
    found = float(moved.fields["conductivity"].control_values()[0])
    second = make_stage(task, ready, 1, moved)
    assert second is not None and np.shape(second.space.mesh.cells)[1] == 10
    assert float(second.fields["conductivity"].control_values()[0]) == pytest.approx(found)
    third = make_stage(task, ready, 2, second)
    assert third is not None and np.shape(third.fields["conductivity"].parameters()) == (1,)
    fourth = make_stage(task, ready, 3, third)
    assert fourth is not None
    assert np.allclose(fourth.fields["conductivity"].control_values(), found, rtol=1e-9)
    assert len(fourth.priors["conductivity"].pairs) > 0
    # Asked again at the same place, the data say the same, and nothing is left to do.
    assert make_stage(task, ready, 4, fourth) is None
    # What the cells make wrong is measured once, with one value, and kept.
    assert not np.any(second.cases[0].defect)
    defect = np.asarray(third.cases[0].defect)
    assert 1e-4 < np.abs(defect).max() < 1.0
    assert np.array_equal(fourth.cases[0].defect, defect)


def test_values_are_corrected_in_the_end_and_go_on_from_where_they_stand(task: Task) -> None:
    alone = replace(task, choice=Uniform(), stages="none")
    first, last = stages(alone, prepare(alone))
    assert not np.any(first.cases[0].defect) and np.any(last.cases[0].defect)
    # It stops later, which is a number: no program is compiled anew.
    assert first.settled == SETTLED_EARLY and last.settled == SETTLED
    assert first.near == NEAR_EARLY and last.near == 0
    assert last.fields is first.fields and jax.tree.structure(last) == jax.tree.structure(first)
    # Where no correction follows, that stage goes to its end.
    bare = replace(alone, meshing=replace(alone.meshing, corrected=False))
    (only,) = stages(bare, prepare(bare))
    assert only.settled == SETTLED and only.near == 0


def test_a_surface_that_is_not_meshed_so_finely_costs_no_fit(
    task: Task, monkeypatch: pytest.MonkeyPatch
) -> None:
    alone = replace(task, choice=Uniform(), stages="none")
    ready = prepare(alone)

    def refuse(*_: object) -> None:
        raise InputError("the mesher did not finish", where="s", value="", limit="", remedy="")

    monkeypatch.setattr("thermo.inverse._defect.mesh_for", refuse)
    first, last = stages(alone, ready)
    assert not np.any(last.cases[0].defect)
    assert last.fields is first.fields and last.settled == SETTLED


def test_without_a_correction_nothing_is_added(task: Task) -> None:
    bare = replace(task, meshing=replace(task.meshing, corrected=False))
    made = list(stages(bare, prepare(bare)))
    assert len(made) == 3 and not any(np.any(one.cases[0].defect) for one in made)
