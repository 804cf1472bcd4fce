"""Small objectives: one of priors alone, which compiles in a moment, and one of real runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import jax.numpy as jnp
import numpy as np

from thermo.fields import QUANTITIES
from thermo.inverse import AbstractFieldChoice, OnControlPoints
from thermo.inverse._case import Case, make_case, stack_cases
from thermo.inverse._minimise import Stage
from thermo.inverse._objective import FieldPrior, Objective, Parameters, start
from thermo.inverse._properties import Stated
from thermo.mesh import box_mesh
from thermo.observe import Run
from thermo.physics import ConjugateGradient, discretise, uniform_steps
from thermo.physics.integrators import Sdirk2

MESH = box_mesh((0.02, 0.012, 0.008), (3, 2, 2))
WHERE = str(Path("scene.json"))


def prior(
    pairs: np.ndarray, centre: float, *, spread: float = 0.1, decay: float = 0.3
) -> FieldPrior:
    return FieldPrior(
        jnp.asarray(pairs),
        jnp.asarray(0.3),
        jnp.asarray(centre),
        jnp.asarray(spread),
        jnp.asarray(decay),
    )


def beliefs(centre: float = 0.8, choice: AbstractFieldChoice | None = None) -> Objective:
    """Priors on two fields that start away from the centres: a smooth problem with one minimum."""
    choice = OnControlPoints(count=4) if choice is None else choice
    fields, priors = {}, {}
    for seed, (name, first, wanted) in enumerate(
        [("conductivity", 2.4, centre), ("convection", 10.0, 30.0)]
    ):
        fields[name], pairs = choice.make(QUANTITIES[name], MESH, first, seed)
        priors[name] = prior(pairs, wanted)
    return Objective(
        discretise(MESH), Stated(1.0, 1.54e6, 10.0, 0.5), fields, priors, (), Sdirk2(),
        ConjugateGradient(rtol=1e-8),
    )  # fmt: skip


def case(run: Run, size: float = 6.0) -> Case:
    """A run on the coarse mesh with long steps [s]."""
    grid = uniform_steps(run.recording.time, size, ())
    return make_case(run, discretise(MESH), grid, model_error=0.01, where=WHERE)


def measured(cases: list[Case]) -> Objective:
    """Runs over a field of conductivity on three control points."""
    choice = OnControlPoints(count=3)
    field, pairs = choice.make(QUANTITIES["conductivity"], MESH, 0.5, 0)
    return Objective(
        discretise(MESH), Stated(0.5, 1.54e6, 25.0, 0.4), {"conductivity": field},
        {"conductivity": prior(pairs, 0.8, decay=0.1)}, stack_cases(cases), Sdirk2(),
        ConjugateGradient(rtol=1e-10),
    )  # fmt: skip


def at(objective: Objective) -> Stage:
    """A stage with this objective, from where the stage before it ended."""

    def made(before: Objective | None) -> Objective:
        return objective if before is None else replace(objective, fields=before.fields)

    return made


def moved(objective: Objective, scale: float = 0.3) -> Parameters:
    """Parameters [1] that differ from control to control."""
    wave = {
        name: jnp.asarray(scale * np.sin(1.0 + np.arange(np.size(raw))).reshape(np.shape(raw)))
        for name, raw in start(objective).items()
    }
    return {name: start(objective)[name] + wave[name] for name in wave}
