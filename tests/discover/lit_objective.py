"""The residual of two runs of a small box, one of which has fewer frames and samples."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
import trimesh
from lit_box import FRAMES, HOT, LAMP, MESH, POINTS, SIZE, SPACE, STATED, run

from thermo.discover import Candidate
from thermo.discover._allowance import allowance
from thermo.discover._bench import Bench
from thermo.discover._descent import Ended
from thermo.discover._extended import Extended
from thermo.discover._standing import Standing
from thermo.fields import QUANTITIES
from thermo.inverse import (
    Case,
    LevenbergMarquardt,
    Meshing,
    Objective,
    OnControlPoints,
    Prior,
    Ready,
    Stepping,
    Task,
    Uniform,
    penalty,
    start,
)
from thermo.inverse._case import group_cases, make_case, stack_cases
from thermo.inverse._objective import FieldPrior
from thermo.observe import Run, Scene, StatedMaterial
from thermo.physics import ConjugateGradient, every_step, uniform_steps
from thermo.physics.integrators import Sdirk2

RUNS = (
    run("lamp", lamp=LAMP, quiet=True),
    # Its frames are read between steps, and it is filled up to the length of the other.
    run("cooling", initial=HOT, time=FRAMES[:-3] + 0.25, points=POINTS[:3]),
)


def case(one: Run) -> Case:
    """A run with few steps, between which its frames are read."""
    time = one.recording.time
    grid = uniform_steps(time, float(time[-1]))
    steps = every_step(uniform_steps(time[-1:], 4.0, one.switches()))
    return make_case(one, SPACE, grid, steps=steps, model_error=0.01, where="scene.json")


def objective(runs: tuple[Run, ...] = RUNS, controls: int = 3) -> Objective:
    """Runs over a field of conductivity."""
    choice = OnControlPoints(count=controls)
    field, pairs = choice.make(QUANTITIES["conductivity"], MESH, 2.0, 0)
    prior = FieldPrior(
        jnp.asarray(pairs), jnp.asarray(0.3), jnp.asarray(3.0), jnp.asarray(0.1), jnp.asarray(0.1)
    )
    cases = [case(one) for one in runs]
    return Objective(
        SPACE, STATED, {"conductivity": field}, {"conductivity": prior}, stack_cases(cases),
        Sdirk2(), ConjugateGradient(rtol=1e-12),
        sequence=tuple(number for group in group_cases(cases) for number in group),
    )  # fmt: skip


def box_task(folder: Path) -> Task:
    """What is asked of the runs, on the surface of the box, which is left in a folder."""
    trimesh.creation.box(bounds=[[0.0] * 3, SIZE]).export(folder / "box.ply")
    material = StatedMaterial("clay", 1100.0, 1400.0, STATED.conductivity)
    scene = Scene(
        folder, "box", folder / "box.ply", "m", material, STATED.convection, STATED.emissivity,
        ("conductivity",), {}, {one.name: one for one in RUNS},
    )  # fmt: skip
    how = (Uniform(), LevenbergMarquardt(), Prior(), Stepping(), Meshing())
    return Task(scene, RUNS, ("conductivity",), *how, "none", {}, 0, 0.01)


def parts(of: Objective) -> list[slice]:
    """Of each run its part of the residual."""
    sizes = [np.size(used) for one in of.cases for used in np.asarray(one.used)]
    ends = np.cumsum([0, *sizes])
    return [slice(a, b) for a, b in zip(ends[:-1], ends[1:], strict=True)]


def partly(kind: type, **fields: object) -> Any:
    """An object with some of its fields alone."""
    made = object.__new__(kind)
    for name, value in fields.items():
        object.__setattr__(made, name, value)
    return made


def standing_at(objective: Objective, *candidates: Candidate) -> Standing:
    """One at which all of the candidates' first parts are at work."""
    point = Extended(start(objective), candidates)
    values = sum(np.size(case.used) for case in objective.cases)
    count = values + penalty(objective, point.fields).size + len(objective.sequence)
    names = [each.card.name for each in candidates]
    ended = Ended(point, np.zeros(count), np.zeros((count, 1)))
    return Standing(
        partly(Bench, coarse=objective, ready=partly(Ready, mesh=MESH)),
        dict(zip(names, candidates, strict=True)), point, tuple((name, 0) for name in names),
        ended, allowance([], np.eye(count)[:, :1]),
    )  # fmt: skip
