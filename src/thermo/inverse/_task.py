"""A fit as it was asked for, and what it needs before it begins."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from typing import final

import jax
import jax.numpy as jnp
import numpy as np

from thermo.fields import QUANTITIES, AbstractField
from thermo.inverse._body import (
    Meshing,
    make_mesh,
    of_order,
    scan_conductivity,
    state,
    surface_of,
)
from thermo.inverse._case import group_cases, make_case, stack_cases
from thermo.inverse._field_choice import AbstractFieldChoice, AbstractStagedChoice
from thermo.inverse._least_squares import LevenbergMarquardt
from thermo.inverse._objective import FieldPrior, Objective, Parameters
from thermo.inverse._optimiser import AbstractOptimiser
from thermo.inverse._properties import Stated
from thermo.inverse._stepping import COARSER, Stepping, fit_frames, planned_steps
from thermo.mesh import Mesh
from thermo.observe import Run, Scene
from thermo.physics import ConjugateGradient, TimeGrid, discretise

FEW_UNKNOWNS = 8
"""Up to this many unknowns [1] the exact Jacobian is taken: it costs a few runs at most."""

TANGENT_RTOL = 1e-2
"""Relative tolerance [1] of the linear solver for coarse tangents, which are no better anyway."""

# Shares of the loss [1] that a step must promise for a fit to go on. Coarse tangents differ from
# the true ones by 0.1 to 0.2 and still promise 1e-3 to 3e-3 where the true ones promise nothing
# more (benchmarks/coarse_tangents.py); what an early stage leaves the last one does.
SETTLED_COARSE = 3e-3
SETTLED_EARLY = 1e-2


@final
@dataclass(frozen=True)
class Prior:
    """What is believed before the data.

    - `step`: standard deviation of log(phi) between neighbouring controls [1]; small is smooth.
    - `spread`: by quantity, the standard deviation of log(phi) about its initial value [1];
      quantities that the scene's own prior names take it from there.
    - `decay`: weight of the squared parameters [1].
    """

    step: float = 0.3
    spread: dict[str, float] = field(default_factory=dict)
    decay: float = 0.0


def _priors(
    fields: dict[str, AbstractField],
    pairs: dict[str, np.ndarray],
    stated: Stated,
    scene: Scene,
    prior: Prior,
) -> dict[str, FieldPrior]:
    spread = {**scene.prior, **prior.spread}
    return {
        name: FieldPrior(
            pairs=jnp.asarray(pairs[name]),
            step=jnp.asarray(prior.step),
            centre=jnp.asarray(stated.of(name)),
            spread=jnp.asarray(spread.get(name, np.inf)),
            decay=jnp.asarray(prior.decay),
        )
        for name in fields
    }


@final
@dataclass(frozen=True)
class Task:
    """Everything that was asked of a fit."""

    scene: Scene
    runs: tuple[Run, ...]
    names: tuple[str, ...]
    choice: AbstractFieldChoice
    optimiser: AbstractOptimiser
    prior: Prior
    stepping: Stepping
    meshing: Meshing
    stages: str
    initial: dict[str, float]
    seed: int
    model_error: float

    def key(self) -> str:
        """A hash that another fit does not share."""
        # How long to go on is not part of the question.
        method = replace(self.optimiser, max_steps=1)
        asked = (self.names, self.choice, method, self.prior, self.stepping)
        where = (replace(self.meshing, cache=None), self.stages, sorted(self.initial.items()))
        scene = self.scene
        body = (scene.material, scene.convection, scene.emissivity, scene.unit, scene.prior)
        digest = hashlib.sha256(repr((asked, where, body, self.seed, self.model_error)).encode())
        digest.update(scene.surface_path.read_bytes())
        for run in self.runs:
            record = run.recording
            around = (run.initial_temperature, run.ambient_temperature, run.radiation_temperature)
            held = [(i.box_min, i.box_max, i.time, i.temperature) for i in run.prescribed]
            digest.update(repr((run.name, around, run.heater)).encode())
            for array in (
                record.points,
                record.time,
                record.temperature,
                record.valid,
                *sum(held, ()),
            ):
                digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()[:16]


@final
@dataclass(frozen=True)
class Ready:
    """The body of a fit: mesh, stated values, fields with their priors.

    Of each run: `grids`, the frames that are fitted, and `steps`, unless frames give them.
    """

    mesh: Mesh
    stated: Stated
    fields: dict[str, AbstractField]
    priors: dict[str, FieldPrior]
    grids: dict[str, TimeGrid]
    steps: dict[str, TimeGrid | None]


def prepare(task: Task) -> Ready:
    """Mesh the body [m], lay out its fields and plan the steps of each run [s]."""
    scene, initial = task.scene, task.initial
    surface = surface_of(scene)
    guess = 1.0
    if scene.material.conductivity is None and not {"conductivity", "diffusivity"} & set(initial):
        guess = scan_conductivity(scene, surface, list(task.runs), task.meshing)
    stated = state(scene, initial, guess)
    mesh = make_mesh(scene, surface, stated.of("diffusivity"), task.meshing)
    fields, pairs = {}, {}
    for number, name in enumerate(task.names):
        made = task.choice.make(QUANTITIES[name], mesh, stated.of(name), task.seed + number)
        fields[name], pairs[name] = made
    priors = _priors(fields, pairs, stated, scene, task.prior)
    grids = {run.name: fit_frames(run, task.stepping) for run in task.runs}
    steps = {run.name: planned_steps(mesh, stated, run, task.stepping) for run in task.runs}
    return Ready(mesh, stated, fields, priors, grids, steps)


def stage_orders(task: Task) -> tuple[int, ...]:
    """The order [1] of the cells in each stage."""
    if task.stages == "tet4_tet10" and task.meshing.order == 2:
        return 1, 2
    return (task.meshing.order,) * (2 if isinstance(task.choice, AbstractStagedChoice) else 1)


def make_stage(task: Task, ready: Ready, number: int, before: Parameters | None) -> Objective:
    """The objective of a stage, which starts where the stage `before` it ended [1]."""
    orders = stage_orders(task)
    last = number + 1 == len(orders)
    if before is not None:
        ready = _go_on(task, ready, before)
    objective = make_objective(task, ready, orders[number])
    return objective if last else replace(objective, settled=SETTLED_EARLY)


def _go_on(task: Task, ready: Ready, before: Parameters) -> Ready:
    fields, priors = {}, {}
    for number, (name, begun) in enumerate(ready.fields.items()):
        prior, ended = ready.priors[name], begun.with_parameters(before[name])
        pairs = np.asarray(prior.pairs)
        if isinstance(task.choice, AbstractStagedChoice):
            ended, pairs = task.choice.go_on(ended, pairs, ready.mesh, task.seed + number)
        fields[name] = ended
        priors[name] = replace(prior, pairs=jnp.asarray(pairs))
    return replace(ready, fields=fields, priors=priors)


def make_objective(task: Task, ready: Ready, order: int) -> Objective:
    """The objective on cells of an order [1], with coarse tangents where they are wanted."""
    unknowns = sum(
        leaf.size for field in ready.fields.values() for leaf in jax.tree.leaves(field.parameters())
    )
    wanted = task.meshing.coarse_tangents
    coarse = unknowns > FEW_UNKNOWNS if wanted is None else wanted
    plain = _plain(task, ready, order, ready.steps, task.stepping.rtol)
    if not (coarse and isinstance(task.optimiser, LevenbergMarquardt)):
        return plain
    steps = {
        run.name: planned_steps(ready.mesh, ready.stated, run, task.stepping, coarser=COARSER)
        for run in task.runs
    }
    tangents = _plain(task, ready, 1, steps, max(task.stepping.rtol, TANGENT_RTOL))
    return replace(plain, tangents=tangents, settled=SETTLED_COARSE)


def _plain(
    task: Task, ready: Ready, order: int, steps: dict[str, TimeGrid | None], rtol: float
) -> Objective:
    space = discretise(of_order(ready.mesh, order))
    cases = [
        make_case(
            run,
            space,
            ready.grids[run.name],
            steps=steps[run.name],
            model_error=task.model_error,
            where=f"{task.scene.folder}: runs.{run.name}.recording",
        )
        for run in task.runs
    ]
    return Objective(
        space,
        ready.stated,
        ready.fields,
        ready.priors,
        stack_cases(cases),
        task.stepping.integrator,
        ConjugateGradient(rtol=rtol),
        task.stepping.lagged,
        sequence=tuple(number for group in group_cases(cases) for number in group),
    )
