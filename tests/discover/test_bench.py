"""The meshes of a search: each is finer than the one that it is to check."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from lit_box import MESH, STATED

from thermo.discover import _bench
from thermo.discover._bench import Bench, finest
from thermo.errors import InputError
from thermo.inverse import FINER, Meshing, Ready, mesh_for

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
