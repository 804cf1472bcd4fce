"""The key of a fit: what changes the answer changes the key, and nothing else does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import equinox as eqx
import numpy as np
import pytest

from thermo.errors import InputError
from thermo.inverse import LevenbergMarquardt, Meshing, Prior, Stepping, Uniform
from thermo.inverse import _task as module
from thermo.inverse._body import state
from thermo.inverse._task import FINER, Task, mesh_for, what_is_asked
from thermo.mesh import Fine, Mesh, box_mesh
from thermo.observe import Air, Box, Course, Noise, Prescribed, Run, Scene


def task(scene: Scene, run: Run) -> Task:
    how = (Uniform(), LevenbergMarquardt(), Prior(), Stepping(), Meshing())
    return Task(scene, (run,), ("conductivity",), *how, "none", {}, 0, 0.01)


def lamp(run: Run, name: str, value: object) -> Run:
    return replace(run, heater=eqx.tree_at(lambda one: getattr(one, name), run.heater, value,
                                           is_leaf=lambda leaf: leaf is None))  # fmt: skip


def read(run: Run, name: str, value: object) -> Run:
    there = eqx.tree_at(lambda one: getattr(one, name), run.recording, value)
    return replace(run, recording=there)


CORNERS = ([0.0, 0.0, 0.0], [1.0, 1.0, 1.0])
HISTORY = ([0.0, 90.0], [300.0, 310.0])
CHANGES: dict[str, Callable[[Run], Run]] = {
    "centre": lambda run: lamp(run, "centre", np.array([0.1, 0.2, 0.3])),
    "direction": lambda run: lamp(run, "direction", np.array([0.0, 1.0, 0.0])),
    "power": lambda run: lamp(run, "power", 3.21),
    "course": lambda run: lamp(run, "course", Course([0.0, 1.0], [0.5, 1.0])),
    "lamp_off": lambda run: replace(run, heater=None),
    "ambient": lambda run: replace(run, ambient_temperature=301.0),
    "insulated": lambda run: replace(run, insulated=(Box(*CORNERS),)),
    "insulated_less": lambda run: replace(run, insulated=(Box(CORNERS[0], CORNERS[0]),)),
    "air": lambda run: replace(run, air=(Air(Box(*CORNERS), 4.0, 300.0),)),
    "air_warmer": lambda run: replace(run, air=(Air(Box(*CORNERS), 4.0, 301.0),)),
    "air_faster": lambda run: replace(run, air=(Air(Box(*CORNERS), 5.0, 300.0),)),
    "prescribed": lambda run: replace(run, prescribed=(Prescribed(*CORNERS, *HISTORY),)),
    "prescribed_else": lambda run: replace(
        run, prescribed=(Prescribed(CORNERS[0], CORNERS[0], *HISTORY),)
    ),
    "noise": lambda run: replace(run, noise=Noise(0.05, 0.1)),
    "noise_that_stays": lambda run: replace(run, noise=Noise(0.05, 0.1, 0.4)),
    "reading": lambda run: read(run, "temperature", run.recording.temperature + 0.1),
    "valid": lambda run: read(run, "valid", np.zeros_like(run.recording.valid)),
}


def test_every_condition_and_reading_is_in_the_key(scene: Scene) -> None:
    run = scene.runs["lamp"]
    keys = {name: task(scene, changed(run)).key() for name, changed in CHANGES.items()}
    keys["as_is"] = task(scene, run).key()
    assert len(set(keys.values())) == len(keys), keys
    assert task(scene, replace(run)).key() == keys["as_is"]


@pytest.mark.parametrize("cache", [Path("elsewhere"), None])
def test_where_meshes_are_kept_is_not_in_the_key(cache: Path | None, scene: Scene) -> None:
    one = task(scene, scene.runs["lamp"])
    assert replace(one, meshing=Meshing(cache=cache)).key() == one.key()


GUESS = {"convection": 10.0, "scaled_convection": 5e-6, "emissivity": 0.8}


@pytest.mark.parametrize("name", list(GUESS))
def test_nothing_is_no_first_value(name: str, scene: Scene) -> None:
    stated = name.removeprefix("scaled_")
    dark = replace(scene, **{stated: 0.0})
    with pytest.raises(InputError, match=f"{stated} is looked for by factors") as caught:
        what_is_asked(dark, None, (name,), None)
    assert caught.value.where.endswith(f"scene.json: surface_exchange.{stated}")
    assert f"initial.{stated}=" in caught.value.remedy
    *_, first = what_is_asked(dark, None, (name,), {name: GUESS[name]})
    assert first == {name: GUESS[name]}
    what_is_asked(dark, None, ("conductivity",), None)
    if stated != name:
        # The other form of it that is nothing begins nowhere either.
        with pytest.raises(InputError, match=f"{stated} is looked for by factors"):
            what_is_asked(dark, None, (name,), {stated: 0.0})
    if stated == name:
        what_is_asked(replace(dark, unknown=(name,), **{name: None}), None, (name,), None)


@pytest.mark.parametrize(
    ("finer", "there"), [(1.0, False), (1.6, False), (FINER, True), (3.0, True)]
)
def test_a_mesh_that_is_measured_against_is_finer_at_inner_edges(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, finer: float, there: bool
) -> None:
    asked: list[tuple[str, tuple[Fine, ...], float]] = []

    def maker(name: str) -> Callable[..., Mesh]:
        def make(*_: object, fine: tuple[Fine, ...], finer: float) -> Mesh:
            asked.append((name, fine, finer))
            return box_mesh((0.01, 0.01, 0.01), (1, 1, 1))

        return make

    for name in ("make_mesh", "mesh_to_measure"):
        monkeypatch.setattr(module, name, maker(name))
    stated = state(scene, {"conductivity": 1.0}, 1.0)
    own = (Fine(np.zeros((1, 3)), 1e-3),)
    mesh_for(task(scene, scene.runs["lamp"]), stated, finer, own)
    assert asked == [("mesh_to_measure" if there else "make_mesh", own, finer)]
