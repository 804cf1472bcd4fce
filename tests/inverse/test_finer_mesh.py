"""The finer mesh of a fit is made beside it, once, and what fails there stops nothing."""

from __future__ import annotations

import threading
from dataclasses import replace
from pathlib import Path

import pytest

from thermo.errors import InputError
from thermo.inverse import LevenbergMarquardt, Meshing, Prior, Stepping, Uniform
from thermo.inverse._finer_mesh import finer_mesh_ahead
from thermo.inverse._task import Ready, Task, prepare
from thermo.observe import read_scene

from .conftest import START

MESH_FOR = "thermo.inverse._finer_mesh.mesh_for"


@pytest.fixture(scope="module")
def task(block: Path, meshing: Meshing) -> Task:
    scene = read_scene(block)
    how = (Uniform(), LevenbergMarquardt(), Prior(), Stepping(), replace(meshing, corrected=True))
    return Task(scene, (scene.runs["lamp"],), ("conductivity",), *how, "none", START, 0, 0.01)


@pytest.fixture(scope="module")
def ready(task: Task) -> Ready:
    return prepare(task)


def test_it_is_begun_at_once_and_waited_for_at_the_end(
    task: Task, ready: Ready, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, go_on, made = threading.Event(), threading.Event(), []

    def slow(_: Task, __: object, finer: float) -> None:
        begun.set()
        assert go_on.wait(10)
        made.append(finer)

    monkeypatch.setattr(MESH_FOR, slow)
    with finer_mesh_ahead(task, ready):
        assert begun.wait(10) and not made
        go_on.set()
    assert made == [2.0]


def test_a_fit_that_is_not_corrected_needs_none(
    task: Task, ready: Ready, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = []
    monkeypatch.setattr(MESH_FOR, lambda *asked: made.append(asked))
    with finer_mesh_ahead(replace(task, meshing=replace(task.meshing, corrected=False)), ready):
        pass
    assert made == []


def test_a_mesher_that_fails_beside_a_fit_stops_nothing(
    task: Task, ready: Ready, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise InputError("the mesher failed", where="s", value="", limit="", remedy="")

    monkeypatch.setattr(MESH_FOR, fail)
    with finer_mesh_ahead(task, ready):
        done = True
    assert done
