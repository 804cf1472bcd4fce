"""The meshes of a search: each is finer than the one that it is to check."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lit_box import MESH, STATED, within

from thermo.discover import _bench
from thermo.discover._bench import Bench, edge_of, finest, resolved
from thermo.errors import InputError
from thermo.inverse import FINER, Meshing, Ready, mesh_for
from thermo.mesh import Fine, Mesh

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
    asked: list[tuple[float, Fine | None]] = []

    def made(task: Any, stated: Any, by: float, fine: Fine | None = None) -> Mesh:
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
    assert plain.finer is bench.finer and asked == [(_bench._SMALLER, None)]
    edges = within((0.010, 0.006, 0.004), [0.002, 0.002, 0.001]).edge(0)[:20]
    resolved(bench, edges)
    (first, near), (second, nearer) = sorted(asked[1:], key=lambda one: one[0])
    assert (first, second) == (_bench._SMALLER, FINER)
    assert near is not None and nearer is not None
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
