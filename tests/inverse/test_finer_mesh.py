"""The finer mesh of a fit is made beside it, once, and a failure tells only whoever asks for it."""

from __future__ import annotations

import threading
from dataclasses import replace
from pathlib import Path

import jax.numpy as jnp
import pytest
from jaxtyping import Array

from thermo.errors import InputError
from thermo.inverse import LevenbergMarquardt, Meshing, Prior, Stepping, Uniform
from thermo.inverse._finer_mesh import finer_mesh_ahead
from thermo.inverse._objective import Objective
from thermo.inverse._stages import make_stage
from thermo.inverse._task import Ready, Task, prepare
from thermo.mesh import Mesh
from thermo.observe import read_scene

from .conftest import START

MAKER = "thermo.inverse._finer_mesh.finer_mesh"


@pytest.fixture(scope="module")
def task(block: Path, meshing: Meshing) -> Task:
    scene = read_scene(block)
    how = (Uniform(), LevenbergMarquardt(), Prior(), Stepping(), replace(meshing, corrected=True))
    return Task(scene, (scene.runs["lamp"],), ("conductivity",), *how, "none", START, 0, 0.01)


@pytest.fixture(scope="module")
def ready(task: Task) -> Ready:
    return prepare(task)


def test_it_is_begun_at_once_and_whoever_asks_waits_for_the_one(
    task: Task, ready: Ready, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, go_on, made = threading.Event(), threading.Event(), []

    def slow(*asked: object) -> Mesh:
        begun.set()
        assert go_on.wait(10)
        made.append(asked)
        return ready.mesh

    monkeypatch.setattr(MAKER, slow)
    with finer_mesh_ahead(task, ready) as finer:
        assert begun.wait(10) and not made and finer is not None
        go_on.set()
        assert finer() is finer() is ready.mesh
    assert len(made) == 1 and made[0][0] is task and made[0][1] is ready


def test_a_fit_that_is_not_corrected_needs_none(
    task: Task, ready: Ready, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = []
    monkeypatch.setattr(MAKER, lambda *asked: made.append(asked))
    bare = replace(task, meshing=replace(task.meshing, corrected=False))
    with finer_mesh_ahead(bare, ready) as finer:
        assert finer is None
    assert made == []


def test_a_mesher_that_fails_tells_only_whoever_asks(
    task: Task, ready: Ready, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise InputError("the mesher failed", where="s", value="", limit="", remedy="")

    monkeypatch.setattr(MAKER, fail)
    with finer_mesh_ahead(task, ready) as finer:
        assert finer is not None
        with pytest.raises(InputError, match="the mesher failed"):
            finer()


def test_the_correction_takes_what_was_made_ahead(
    task: Task, ready: Ready, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []

    def defects(_: Task, __: Ready, before: Objective, mesh: Mesh) -> list[Array]:
        seen.append(mesh)
        return [jnp.zeros(case.data.shape) for case in before.cases]

    def refuse(*_: object) -> Mesh:
        raise AssertionError("meshed a second time")

    monkeypatch.setattr("thermo.inverse._defect.defects", defects)
    monkeypatch.setattr("thermo.inverse._defect.mesh_for", refuse)
    first = make_stage(task, ready, 0, None)
    assert make_stage(task, ready, 1, first, finer=lambda: ready.mesh) is not None
    assert len(seen) == 1 and seen[0] is ready.mesh
