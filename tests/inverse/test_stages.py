"""Which stages a fit has, and when the data choose the smoothness."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

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
from thermo.inverse._stages import ASKED, data_choose, make_stage, stage_orders
from thermo.inverse._task import Ready, Task, prepare
from thermo.observe import Scene, read_scene
from thermo.physics.integrators import BackwardEuler

from .conftest import START

POINTS = OnControlPoints(count=4)


@pytest.fixture(scope="module")
def task(block: Path, meshing: Meshing) -> Task:
    scene: Scene = read_scene(block)
    stepping = Stepping(integrator=BackwardEuler(), size=3.0)
    how = (POINTS, LevenbergMarquardt(), Prior(), stepping, replace(meshing, order=2))
    return Task(scene, (scene.runs["lamp"],), ("conductivity",), *how, "tet4_tet10", START, 0, 0.01)


@pytest.fixture(scope="module")
def ready(task: Task) -> Ready:
    return prepare(task)


@pytest.mark.parametrize(
    ("change", "asked", "orders"),
    [
        ({}, True, (1, 2, *(2,) * ASKED)),
        ({"stages": "none"}, True, (2, *(2,) * ASKED)),
        ({"choice": Patchwise(patches=3)}, True, (1, 2, *(2,) * ASKED)),
        ({"prior": Prior(step=0.3)}, False, (1, 2)),
        ({"prior": Prior(step=0.3), "stages": "none"}, False, (2,)),
        ({"optimiser": Adam()}, False, (1, 2)),
        ({"choice": Uniform()}, False, (1, 2)),
        ({"choice": TwoMaterials(count=6)}, False, (1, 2)),
        ({"choice": TwoMaterials(count=6), "stages": "none"}, False, (2, 2)),
        ({"choice": Network(count=4, width=32)}, False, (1, 2)),
    ],
)
def test_the_stages_of_a_fit(
    change: dict[str, Any], asked: bool, orders: tuple[int, ...], task: Task
) -> None:
    other = replace(task, **change)
    ready = prepare(other)
    assert data_choose(other, ready) is asked
    assert stage_orders(other, ready) == orders


def test_one_value_comes_first_and_the_field_begins_with_it(task: Task, ready: Ready) -> None:
    first = make_stage(task, ready, 0, None)
    assert first is not None
    field = first.fields["conductivity"]
    assert np.shape(field.parameters()) == (1,)
    assert float(field.control_values()[0]) == pytest.approx(START["conductivity"])
    assert np.shape(first.space.mesh.cells)[1] == 4
    moved = replace(first, fields={"conductivity": field.with_parameters(field.parameters() + 0.5)})
    second = make_stage(task, ready, 1, moved)
    assert second is not None and np.shape(second.space.mesh.cells)[1] == 10
    found = float(second.fields["conductivity"].control_values()[0])
    assert found == pytest.approx(float(moved.fields["conductivity"].control_values()[0]))
    third = make_stage(task, ready, 2, second)
    assert third is not None
    assert np.allclose(third.fields["conductivity"].control_values(), found, rtol=1e-9)
    assert len(third.priors["conductivity"].pairs) > 0
    # Asked again at the same place, the data say the same, and nothing is left to do.
    assert make_stage(task, ready, 3, third) is None


def test_what_the_mesh_makes_wrong_is_measured_once_and_kept(task: Task, ready: Ready) -> None:
    uniform = make_stage(task, ready, 1, make_stage(task, ready, 0, None))
    assert uniform is not None and not np.any(uniform.cases[0].defect)
    first = make_stage(task, ready, 2, uniform)
    assert first is not None
    defect = np.asarray(first.cases[0].defect)
    assert 1e-4 < np.abs(defect).max() < 1.0
    # Elsewhere the data ask for another smoothness; the defect is that of the one value.
    field = first.fields["conductivity"]
    apart = field.parameters() + np.linspace(-0.5, 0.5, 4)
    moved = replace(first, fields={"conductivity": field.with_parameters(apart)})
    second = make_stage(task, ready, 3, moved)
    assert second is not None and np.array_equal(second.cases[0].defect, defect)
    without = replace(task, meshing=replace(task.meshing, corrected=False))
    bare = make_stage(without, ready, 2, uniform)
    assert bare is not None and not np.any(bare.cases[0].defect)
