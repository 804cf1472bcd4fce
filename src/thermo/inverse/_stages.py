"""The stages of a fit: which cells each one has, and what it makes small."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np

from thermo.inverse._body import of_order
from thermo.inverse._case import group_cases, make_case, stack_cases
from thermo.inverse._field_choice import AbstractStagedChoice
from thermo.inverse._least_squares import LevenbergMarquardt
from thermo.inverse._objective import Objective
from thermo.inverse._smoothing import chosen_by_data, much_the_same
from thermo.inverse._stepping import COARSER, planned_steps
from thermo.inverse._task import Ready, Task
from thermo.physics import ConjugateGradient, TimeGrid, discretise

FEW_UNKNOWNS = 8
"""Up to this many unknowns [1] the exact Jacobian is taken: it costs a few runs at most."""

MOST_UNKNOWNS = 500
"""Up to this many unknowns [1] the data choose the smoothness: it takes a dense Jacobian."""

TANGENT_RTOL = 1e-2
"""Relative tolerance [1] of the linear solver for coarse tangents, which are no better anyway."""

# Shares of the loss [1] that a step must promise for a fit to go on. Coarse tangents differ from
# the true ones by 0.1 to 0.2 and still promise 1e-3 to 3e-3 where the true ones promise nothing
# more (benchmarks/coarse_tangents.py); what an early stage leaves the last one does.
SETTLED_COARSE = 3e-3
SETTLED_EARLY = 1e-2


def _unknowns(ready: Ready) -> int:
    fields = ready.fields.values()
    return sum(leaf.size for field in fields for leaf in jax.tree.leaves(field.parameters()))


def data_choose(task: Task, ready: Ready) -> bool:
    """Whether the data choose how smooth the fields are [1]."""
    rough = any(len(prior.pairs) for prior in ready.priors.values())
    staged = isinstance(task.choice, AbstractStagedChoice)
    few = _unknowns(ready) <= MOST_UNKNOWNS
    return task.prior.step is None and rough and few and not staged


def stage_orders(task: Task, ready: Ready) -> tuple[int, ...]:
    """The order [1] of the cells in each stage.

    Where the data choose the smoothness there are a first stage that knows nothing of it, one with
    what the data ask for there, and a last one where they then ask for something else.
    """
    order = task.meshing.order
    first = 1 if task.stages == "tet4_tet10" else order
    if data_choose(task, ready):
        return first, order, order
    if first != order or isinstance(task.choice, AbstractStagedChoice):
        return first, order
    return (order,)


def make_stage(task: Task, ready: Ready, number: int, before: Objective | None) -> Objective | None:
    """The objective of a stage, from where the stage `before` it ended [1].

    None where the last stage would repeat the one before it.
    """
    orders = stage_orders(task, ready)
    if before is not None:
        ready = _go_on(task, ready, before)
    objective = make_objective(task, ready, orders[number])
    if not data_choose(task, ready):
        early = number + 1 < len(orders)
        return replace(objective, settled=SETTLED_EARLY) if early else objective
    if before is None:
        return replace(objective, settled=SETTLED_EARLY)
    samples = [run.recording.points for run in task.runs]
    coarse = objective.tangents or _tangents(task, ready)
    chosen = chosen_by_data(replace(objective, tangents=coarse), samples)
    if objective.tangents is None:
        chosen = replace(chosen, tangents=None)
    repeated = number > 1 and much_the_same(before, chosen)
    return None if repeated else chosen


def _go_on(task: Task, ready: Ready, before: Objective) -> Ready:
    fields, priors = {}, {}
    for number, (name, ended) in enumerate(before.fields.items()):
        prior = ready.priors[name]
        pairs = np.asarray(prior.pairs)
        if isinstance(task.choice, AbstractStagedChoice):
            ended, pairs = task.choice.go_on(ended, pairs, ready.mesh, task.seed + number)
        fields[name] = ended
        priors[name] = replace(prior, pairs=jnp.asarray(pairs))
    return replace(ready, fields=fields, priors=priors)


def make_objective(task: Task, ready: Ready, order: int) -> Objective:
    """The objective on cells of an order [1], with coarse tangents where they are wanted."""
    wanted = task.meshing.coarse_tangents
    coarse = _unknowns(ready) > FEW_UNKNOWNS if wanted is None else wanted
    plain = _plain(task, ready, order, ready.steps, task.stepping.rtol)
    if not (coarse and isinstance(task.optimiser, LevenbergMarquardt)):
        return plain
    return replace(plain, tangents=_tangents(task, ready), settled=SETTLED_COARSE)


def _tangents(task: Task, ready: Ready) -> Objective:
    """The objective on linear cells and about half as many steps."""
    steps = {
        run.name: planned_steps(ready.mesh, ready.stated, run, task.stepping, coarser=COARSER)
        for run in task.runs
    }
    return _plain(task, ready, 1, steps, max(task.stepping.rtol, TANGENT_RTOL))


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
