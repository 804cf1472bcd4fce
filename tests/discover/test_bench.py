"""The meshes of a search: each is finer than the one that it is to check."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lit_box import MESH, STATED, within

from thermo.discover import Candidate, _bench
from thermo.discover._bench import (
    Apart,
    Bench,
    corrected,
    edge_of,
    finer_runs,
    finest,
    resolved,
)
from thermo.discover._extended import Extended, readings
from thermo.discover._memory import Memory
from thermo.discover.candidates import ClockOffset, HeaterPower
from thermo.errors import InputError
from thermo.inverse import FINER, Meshing, Ready, mesh_for, start, with_defects, with_remainders
from thermo.mesh import Fine, Mesh
from thermo.physics import uniform_steps

from .lit_objective import box_task, objective


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    task = box_task(tmp_path_factory.mktemp("box"))
    coarse = replace(task, meshing=Meshing(max_nodes=300))
    return Bench(coarse, Ready(MESH, STATED, {}, {}, {}, {}), objective(), MESH)


def test_a_slight_alarm_is_checked_on_smaller_cells_than_all_else(bench: Bench) -> None:
    after = finest(bench)
    usual = mesh_for(bench.task, STATED, FINER)
    # Edges of two thirds would be 3.4 times as many cells; those at the skin count for most.
    assert len(after.finer.cells) > 1.8 * len(usual.cells)
    assert after.ready is bench.ready and after.coarse is bench.coarse


def test_where_there_can_be_none_the_bench_stays(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def refuse(*_: Any) -> None:
        raise InputError("too fine", where=str(tmp_path), value="3", limit="2", remedy="less")

    monkeypatch.setattr(_bench, "mesh_for", refuse)
    assert finest(bench) is bench


def test_cells_are_small_about_the_edge_of_a_place_on_both_meshes(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[float, tuple[Fine, ...]]] = []

    def made(task: Any, stated: Any, by: float, fine: tuple[Fine, ...] = ()) -> Mesh:
        asked.append((by, fine))
        return MESH

    fakes: dict[str, Any] = {
        "mesh_for": made,
        "lay_out": lambda *_: bench.ready,
        "coarse_tangents": lambda *_: bench.coarse,
    }
    for name, fake in fakes.items():
        monkeypatch.setattr(_bench, name, fake)
    plain = resolved(bench, np.zeros((0, 3)))
    assert plain.finer is bench.finer and asked == [(_bench._SMALLER, ())]
    edges = within((0.010, 0.006, 0.004), [0.002, 0.002, 0.001]).edge(0)[:20]
    resolved(bench, edges)
    (first, (near,)), (second, (nearer,)) = sorted(asked[1:], key=lambda one: one[0])
    assert (first, second) == (_bench._SMALLER, FINER)
    assert near.points is edges and nearer.points is edges
    assert near.edge == pytest.approx(edge_of(bench) / _bench._AT_EDGES)
    assert nearer.edge == pytest.approx(near.edge / _bench._SMALLER)


@settings(max_examples=30, deadline=None)
@given(st.floats(1e-5, 1e-2), st.floats(20.0, 4000.0))
def test_a_large_place_gets_no_more_nodes_than_it_may(wanted: float, most: float) -> None:
    edges = within((0.010, 0.006, 0.004), [0.006, 0.003, 0.002]).edge(0)
    edge = _bench._edge_about(edges, wanted, most)
    count = len(np.unique(np.floor((edges - edges.min(axis=0)) / edge), axis=0))
    assert edge >= wanted and count <= most
    assert edge == wanted or edge < 0.01


def test_a_clock_that_is_off_reads_the_body_as_it_is_on_finer_cells(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    coarse = objective()
    none = [jnp.zeros_like(case.data) for case in coarse.cases]
    bench = replace(bench, coarse=with_remainders(coarse, none))
    # Where a run has nothing, finer ones have nothing either.
    used = [case.used > 0 for case in coarse.cases]

    def shaped(wave: Callable[[jax.Array], jax.Array]) -> Apart:
        each = (wave(jnp.arange(one.size, dtype=float)).reshape(one.shape) for one in used)
        return [jnp.where(here, one, 0.0) for here, one in zip(used, each, strict=True)]

    # What cells make wrong of the body, and what a clock reads otherwise of a body's every frame.
    wrong, frames = shaped(jnp.sin), shaped(jnp.cos)
    finer = with_remainders(with_defects(coarse, wrong), none)

    def finer_runs(_: Bench, point: Extended) -> Apart:
        late = float(point.candidates[0].strength[0])
        every = zip(readings(finer, point), frames, used, strict=True)
        return [jnp.where(here, one + late * more, jnp.nan) for one, more, here in every]

    monkeypatch.setattr(_bench, "finer_runs", finer_runs)
    lamp = HeaterPower(jnp.array([0.1]))
    late = Extended(start(coarse), (ClockOffset(jnp.array([0.7])), lamp))
    after = corrected(bench, late, finer_runs(bench, late))
    for case, body, read in zip(after.coarse.cases, wrong, frames, strict=True):
        assert np.allclose(case.defect, body) and np.allclose(case.remainder, 0.7 * read)
    there = finer_runs(bench, late)
    for here, read, wanted in zip(used, readings(after.coarse, late), there, strict=True):
        assert np.allclose(read[here], wanted[here])
    # Without it all that is wrong is the body's, and nothing of what it read is left.
    quiet = replace(late, candidates=(ClockOffset(jnp.zeros(1)), lamp))
    anew = corrected(after, quiet, finer_runs(bench, quiet))
    for case, body in zip(anew.coarse.cases, wrong, strict=True):
        assert np.allclose(case.defect, body) and not np.any(case.remainder)


def test_effects_on_the_readings_share_the_runs_of_the_body(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    task, coarse = box_task(tmp_path), objective()
    times = {one.name: one.recording.time for one in task.runs}
    grids = {name: uniform_steps(time, float(time[-1])) for name, time in times.items()}
    ready = Ready(MESH, STATED, {}, {}, grids, {})
    bench = Bench(task, ready, coarse, MESH, Memory())
    asked: list[tuple[Candidate, ...]] = []

    def temperatures(task: Task, *given: Any) -> list[np.ndarray]:
        asked.append(given[-1])
        records = [task.runs[number].recording for number in coarse.sequence]
        return [np.full(one.temperature.shape, 300.0) + one.time[:, None] for one in records]

    monkeypatch.setattr(_bench, "finer_temperatures", temperatures)
    lamp, late = HeaterPower(jnp.array([0.1])), ClockOffset(jnp.array([0.7]))
    still = finer_runs(bench, Extended(start(coarse), (lamp,)))
    moved = finer_runs(bench, Extended(start(coarse), (late, lamp)))
    assert asked == [(lamp,)]
    for one, other in zip(still, moved, strict=True):
        known = np.isfinite(one)
        assert np.array_equal(known, np.isfinite(other)) and known.any()
        # A body that warms by a kelvin a second is read 0.7 K off, all through or nearly so.
        assert np.median(np.abs(np.asarray(other - one)[known])) == pytest.approx(0.7, rel=1e-3)
