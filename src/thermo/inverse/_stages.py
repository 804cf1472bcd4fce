"""The stages of a fit: which cells each one has, and what it makes small."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import jax
import numpy as np

from thermo.inverse._body import of_order
from thermo.inverse._case import group_cases, make_case, stack_cases
from thermo.inverse._defect import less_defects, with_defects
from thermo.inverse._field_choice import AbstractStagedChoice, Uniform
from thermo.inverse._least_squares import LevenbergMarquardt
from thermo.inverse._objective import SETTLED, Objective
from thermo.inverse._smoothing import ask_data, much_the_same, with_choice
from thermo.inverse._stepping import COARSER, longest_reach, planned_steps, scheme_for
from thermo.inverse._task import Ready, Task
from thermo.mesh import Mesh
from thermo.physics import ConjugateGradient, TimeGrid, discretise

FEW_UNKNOWNS = 8
"""Up to this many unknowns [1] the exact Jacobian is taken: it costs a few runs at most."""

MOST_UNKNOWNS = 500
"""Up to this many unknowns [1] the data choose the smoothness: it takes a dense Jacobian."""

ASKED = 3
"""How often the data are asked at the most how smooth the fields are [1]."""

GAIN_ASKED = 1.0
"""Gain of a step [1] below which a fit has settled once readings weigh what they are worth: in
units of log-likelihood, so that what is left lies within what the data allow."""

TANGENT_RTOL = 1e-2
"""Relative tolerance [1] of the linear solver for coarse tangents, which are no better anyway."""

# Shares of the loss [1] that a step must promise for a fit to go on. Coarse tangents differ from
# the true ones by 0.1 to 0.2 and still promise 1e-3 to 3e-3 where the true ones promise nothing
# more (benchmarks/coarse_tangents.py); what an early stage leaves the last one does.
SETTLED_COARSE = 3e-3
SETTLED_EARLY = 1e-2

NEAR_EARLY = 0.05
"""Change of a parameter [1] by a step that is the last of an early stage. Where it leads hundredths
of that are left, a fifth with coarse tangents, and what is measured there is off by as little."""


def _unknowns(ready: Ready) -> int:
    fields = ready.fields.values()
    return sum(leaf.size for field in fields for leaf in jax.tree.leaves(field.parameters()))


def data_choose(task: Task, ready: Ready) -> bool:
    """Whether the data choose how smooth the fields are [1]."""
    rough = any(len(prior.pairs) for prior in ready.priors.values())
    staged = isinstance(task.choice, AbstractStagedChoice)
    few = _unknowns(ready) <= MOST_UNKNOWNS
    # An optimiser of fixed length would go all its way in each of the stages that this takes.
    settles = not task.optimiser.fixed_length()
    return task.prior.step is None and rough and few and settles and not staged


def stage_orders(task: Task, ready: Ready) -> tuple[int, ...]:
    """The order [1] of the cells in each stage.

    Where an optimiser stops by itself, what cells and steps make wrong is measured in the end and
    taken off, and the fit goes on. Where the data choose the smoothness, all that is done with one
    value for the body; then comes the field, and again where the data ask for another smoothness.
    """
    order = task.meshing.order
    first = 1 if task.stages == "tet4_tet10" else order
    both = (first, order) if first != order else (order,)
    if isinstance(task.choice, AbstractStagedChoice):
        both = (first, order)
    asked = ASKED if data_choose(task, ready) else 0
    return (*both, *(order,) * corrected(task), *(order,) * asked)


def corrected(task: Task) -> bool:
    """Whether what cells and steps make wrong is to be taken off [1]."""
    return task.meshing.corrected and not task.optimiser.fixed_length()


def make_stage(
    task: Task,
    ready: Ready,
    number: int,
    before: Objective | None,
    *,
    finer: Callable[[], Mesh] | None = None,
) -> Objective | None:
    """The objective of a stage, from where the stage `before` it ended [1].

    None where the stage would repeat the one before it. `finer` as for `less_defects` [m].
    """
    orders = stage_orders(task, ready)
    asked = ASKED if data_choose(task, ready) else 0
    plain = len(orders) - asked
    if number >= plain:
        assert before is not None, "a field begins with the value of the whole body"
        return _asked_stage(task, ready, orders[number], before, first=number == plain)
    last = plain - 1 - corrected(task)
    if number > last:
        assert before is not None, "fields have been fitted"
        return less_defects(task, ready, _to_its_end(before), finer)
    if asked:
        ready = _one_value(ready, before)
    elif before is not None:
        ready = _go_on(task, ready, before)
    objective = make_objective(task, ready, orders[number])
    # What is to be corrected hardly changes over the rest of the way, which the corrected fit goes.
    ends = number == plain - 1
    return objective if ends else replace(objective, settled=SETTLED_EARLY, near=NEAR_EARLY)


def _asked_stage(
    task: Task, ready: Ready, order: int, before: Objective, *, first: bool
) -> Objective | None:
    """The fields as smooth as the data ask for where they stand; None where that is as before."""
    ready = _from_one_value(task, ready, before) if first else _go_on(task, ready, before)
    apart = [case.defect for case in before.cases]
    objective = with_defects(make_objective(task, ready, order), apart)
    here = objective
    if here.tangents is None:
        here = replace(here, tangents=coarse_tangents(task, ready))
    choice = ask_data(here, [run.recording.points for run in task.runs])
    chosen = replace(with_choice(objective, choice), gain=GAIN_ASKED)
    return None if not first and much_the_same(before, chosen) else chosen


def _one_value(ready: Ready, before: Objective | None) -> Ready:
    """One value for the body in place of each field."""
    fields, priors = {}, {}
    for name, field in ready.fields.items():
        level = float(field.control_values()[0])
        uniform, pairs = Uniform().make(field.quantity, ready.mesh, level, 0)
        fields[name] = uniform if before is None else before.fields[name]
        priors[name] = replace(ready.priors[name], pairs=pairs)
    return replace(ready, fields=fields, priors=priors)


def _from_one_value(task: Task, ready: Ready, before: Objective) -> Ready:
    """Fields that begin with the value that was found for the whole body."""
    fields = {}
    for number, (name, found) in enumerate(before.fields.items()):
        level = float(found.control_values()[0])
        fields[name], _ = task.choice.make(found.quantity, ready.mesh, level, task.seed + number)
    return replace(ready, fields=fields)


def _go_on(task: Task, ready: Ready, before: Objective) -> Ready:
    fields, priors = {}, {}
    for number, (name, ended) in enumerate(before.fields.items()):
        prior = ready.priors[name]
        pairs = np.asarray(prior.pairs)
        if isinstance(task.choice, AbstractStagedChoice):
            ended, pairs = task.choice.go_on(ended, pairs, ready.mesh, task.seed + number)
        fields[name] = ended
        priors[name] = replace(prior, pairs=pairs)
    return replace(ready, fields=fields, priors=priors)


def _to_its_end(objective: Objective) -> Objective:
    """The objective with the stop [1] of a stage after which none follows."""
    coarse = objective.tangents is not None
    return replace(objective, settled=SETTLED_COARSE if coarse else SETTLED, near=0.0)


def make_objective(task: Task, ready: Ready, order: int) -> Objective:
    """The objective on cells of an order [1], with coarse tangents where they are wanted."""
    wanted = task.meshing.coarse_tangents
    coarse = _unknowns(ready) > FEW_UNKNOWNS if wanted is None else wanted
    plain = plain_objective(task, ready, order, ready.steps, task.stepping.rtol)
    if not (coarse and isinstance(task.optimiser, LevenbergMarquardt)):
        return plain
    return _to_its_end(replace(plain, tangents=coarse_tangents(task, ready)))


def coarse_tangents(task: Task, ready: Ready) -> Objective:
    """The objective on linear cells and about half as many steps."""
    steps = {
        run.name: planned_steps(ready.mesh, ready.stated, run, task.stepping, coarser=COARSER)
        for run in task.runs
    }
    return plain_objective(task, ready, 1, steps, max(task.stepping.rtol, TANGENT_RTOL))


def plain_objective(
    task: Task, ready: Ready, order: int, steps: dict[str, TimeGrid | None], rtol: float
) -> Objective:
    """The objective on cells of an order, with the `rtol` of its solver [1] and no tangents."""
    scheme = scheme_for(task.stepping.integrator, ready.stated)
    planned = [steps[run.name] or ready.grids[run.name] for run in task.runs]
    reach = longest_reach(scheme, planned, ready.stated.of("diffusivity"))
    space = discretise(of_order(ready.mesh, order), reach)
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
        scheme,
        ConjugateGradient(rtol=rtol),
        task.stepping.lagged,
        sequence=tuple(number for group in group_cases(cases) for number in group),
    )
