"""What cells and steps make wrong: measured without data, and worth taking off."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from thermo.inverse import LevenbergMarquardt, Meshing, OnControlPoints, Prior, Stepping
from thermo.inverse._addition import AbstractReadingAddition
from thermo.inverse._case import in_kelvin
from thermo.inverse._conditions import Conditions
from thermo.inverse._defect import (
    defect_sizes,
    defects,
    finer_readings,
    with_defects,
    with_shared,
)
from thermo.inverse._objective import Objective, residual, run_parts, start
from thermo.inverse._reading_errors import whiten
from thermo.inverse._stages import make_stage
from thermo.inverse._task import FINER, Ready, Task, mesh_for, prepare
from thermo.observe import Run, Scene

pytestmark = pytest.mark.usefixtures("bricks")

TRUTH = {"conductivity": 0.8}
FEWER = 6


def shortened(run: Run) -> Run:
    """A run without its last frames."""
    record = run.recording
    kept = replace(
        record,
        time=record.time[:-FEWER],
        temperature=record.temperature[:-FEWER],
        valid=record.valid[:-FEWER],
    )
    return replace(run, recording=kept)


class Late(AbstractReadingAddition):
    """Each frame is read as the one before it was, from where the body began."""

    def to_readings(self, temperature: Array, time: Array, under: Conditions) -> Array:
        assert len(time) == len(temperature)
        first = jnp.full_like(temperature[:1], under.initial)
        return jnp.concatenate([first, temperature[:-1]])


@pytest.fixture(scope="module")
def task(scene: Scene, meshing: Meshing) -> Task:
    """Two runs of one kind and of different lengths, on linear cells and long steps."""
    runs = (scene.runs["lamp"], shortened(scene.runs["test_lamp"]))
    how = (OnControlPoints(count=4), LevenbergMarquardt(), Prior(), Stepping(tolerance=0.5))
    return Task(scene, runs, ("conductivity",), *how, meshing, "none", TRUTH, 0, 0.01)


@pytest.fixture(scope="module")
def ready(task: Task) -> Ready:
    return prepare(task)


@pytest.fixture(scope="module")
def plain(task: Task, ready: Ready) -> Objective:
    objective = make_stage(task, ready, 0, None)
    assert objective is not None
    return objective


def measured(task: Task, ready: Ready, before: Objective) -> list[Array]:
    return defects(task, ready, before, mesh_for(task, ready.stated, FINER))


def errors(objective: Objective) -> list[np.ndarray]:
    """Simulated less recorded temperatures of each run [K]."""
    plain = replace(objective, cases=tuple(in_kelvin(case) for case in objective.cases))
    value = np.asarray(eqx.filter_jit(residual)(plain, start(plain)))
    parts = [value[part][weight.ravel() > 0] for _, part, weight in run_parts(plain)]
    assert all(len(part) for part in parts)
    return parts


def test_the_defect_takes_off_most_of_what_cells_and_steps_make_wrong(
    task: Task, ready: Ready, plain: Objective
) -> None:
    (apart,) = measured(task, ready, plain)
    assert apart.shape == plain.cases[0].data.shape
    padding = apart[plain.sequence.index(1), -FEWER:]
    assert not np.any(padding), "frames that a shorter run lacks need nothing"
    corrected = with_defects(plain, [apart])
    better = errors(corrected)
    for before, after in zip(errors(plain), better, strict=True):
        # Another program made the recordings. Linear cells of half the length leave a quarter.
        assert np.std(after) < 0.5 * np.std(before)
    (case,) = with_shared(corrected).cases
    # What is left of it may be off by a third of it in all readings at once.
    wanted = jax.vmap(whiten)(case.errors, case.used, apart / 3)
    assert np.allclose(case.shared, wanted)
    second = plain.sequence.index(1)
    shown = np.asarray(apart)[second][np.asarray(plain.cases[0].used)[second] > 0]
    assert defect_sizes(corrected)[1] == pytest.approx(np.sqrt(np.mean(shown**2)))
    assert set(defect_sizes(plain).values()) == {0.0}


def test_a_field_that_varies_is_measured_as_it_stands(
    task: Task, ready: Ready, plain: Objective
) -> None:
    (even,) = measured(task, ready, plain)
    field = ready.fields["conductivity"]
    # Steep enough that no luck with a mesh hides it: 0.6 to 1.5 on four meshes.
    moved = jnp.linspace(-2.0, 2.0, len(field.control_values()))
    tilted = field.with_parameters(field.parameters() + moved)
    (apart,) = measured(task, ready, replace(plain, fields={"conductivity": tilted}))
    # Were the field taken as one value they would be equal.
    assert np.abs(apart - even).max() > 0.3 * np.abs(even).max()


def test_recordings_do_not_enter(task: Task, ready: Ready, plain: Objective) -> None:
    def warmer(run: Run) -> Run:
        record = run.recording
        return replace(run, recording=replace(record, temperature=record.temperature + 5.0))

    other = replace(task, runs=tuple(warmer(run) for run in task.runs))
    for mine, theirs in zip(
        measured(task, ready, plain), measured(other, ready, plain), strict=True
    ):
        assert np.array_equal(mine, theirs)


def test_readings_of_finer_runs_are_laid_out_as_the_cases(
    task: Task, ready: Ready, plain: Objective
) -> None:
    # Frames that a fit has, of all that the recordings have, numbered.
    shapes = [task.runs[number].recording.temperature.shape for number in plain.sequence]
    body_at = [300.0 + np.arange(np.prod(one), dtype=float).reshape(one) for one in shapes]
    (case,) = plain.cases
    for additions, before in (((), 0), ((Late(),), 1)):
        (laid,) = finer_readings(task, ready, plain, body_at, additions)
        for row, number, all_frames in zip(laid, plain.sequence, body_at, strict=True):
            run = task.runs[number]
            wanted = np.asarray(ready.grids[run.name].frame_time)
            at = np.abs(run.recording.time[:, None] - wanted).argmin(axis=0)
            first = np.full_like(all_frames[:1], run.initial_temperature)
            read = np.concatenate([first, all_frames])[at + 1 - before]
            np.testing.assert_allclose(row[: len(wanted)], read)
            assert np.isnan(row[len(wanted) :]).all()
        assert laid.shape == case.data.shape
