"""What the cells and the steps of a fit make wrong, measured against finer ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo._compiled import program
from thermo.errors import InputError
from thermo.inverse._addition import AbstractHeatAddition, Addition, read_now
from thermo.inverse._case import Case, one_run
from thermo.inverse._estimate import recovered
from thermo.inverse._forward import forward
from thermo.inverse._objective import (
    Objective,
    Parameters,
    case_temperatures,
    run_parts,
    start,
    with_fields,
)
from thermo.inverse._properties import properties
from thermo.inverse._reading_errors import whiten
from thermo.inverse._side_by_side import at_once
from thermo.inverse._stepping import free_grid
from thermo.inverse._task import FINER, Ready, Task, mesh_for
from thermo.inverse._transfer import carry_over
from thermo.mesh import Mesh
from thermo.observe import Run

SHORTER: Final = 0.2
"""Error of a step of the finer run over that of the fit's [1]."""

DEFECT_LEFT: Final = 1 / 3
"""What the finer run is still wrong by, over the defect [1]: halving the edges leaves a third of
the difference in errors of second order, and less in those of higher order."""

DEFECT_SPREAD: Final = DEFECT_LEFT / 3**0.5
"""Standard deviation of that where the order is not known [1]: of a share that is even up to
`DEFECT_LEFT`, which lies within what 95 % intervals make of it."""

Defects = Sequence[Float[Array, "runs frames samples"]]
"""What is added to the temperatures of each group of runs [K]."""


def finer_mesh(task: Task, ready: Ready) -> Mesh:
    """The mesh [m] on which defects are measured. Raises `InputError` where it cannot be made."""
    return mesh_for(task, ready.stated, FINER)


def less_defects(
    task: Task, ready: Ready, before: Objective, finer: Callable[[], Mesh] | None = None
) -> Objective:
    """The objective with its defects measured where it stands and taken off.

    As it is where the surface cannot be meshed so finely: what was done need not be lost for that.
    `finer` gives the finer mesh [m] where it is being made already.
    """
    try:
        mesh = finer_mesh(task, ready) if finer is None else finer()
    except InputError:
        return before
    return with_defects(before, defects(task, ready, before, mesh))


def defects(
    task: Task, ready: Ready, before: Objective, finer: Mesh
) -> list[Float[Array, "runs frames samples"]]:
    """By how much runs on a `finer` mesh [m] read more than those of `before` [K], where it stands.

    Added to the simulation of fields near these, it takes off most of what cells and steps make
    wrong: values move by it, and a field would bend to it where temperatures alone do not show it.
    The fit's own mesh stays as coarse as it is, and so does the cost of a step of the fit.

    Source: Stetter, Numerische Mathematik 29 (1978) 425, the defect correction; Kaipio and
    Somersalo, J. Comput. Appl. Math. 198 (2007) 493, the mean of the approximation error.
    """
    there, here = at_once(
        lambda read: read(),
        (
            lambda: finer_readings(
                task, ready, before, finer_temperatures(task, ready, before, start(before), finer)
            ),
            lambda: [np.asarray(one) for one in _temperatures(before)],
        ),
    )
    return [
        jnp.asarray(np.where(np.isnan(finer), 0.0, finer - mine))
        for finer, mine in zip(there, here, strict=True)
    ]


def finer_temperatures(
    task: Task,
    ready: Ready,
    like: Objective,
    parameters: Parameters,
    mesh: Mesh,
    additions: tuple[AbstractHeatAddition, ...] = (),
) -> list[Float[np.ndarray, "_frames _samples"]]:
    """Temperatures of finer runs [K], each at all frames of its recording, in the order of `like`.

    Arguments: `parameters`: of its fields [1]; `mesh`: the finer one [m]; `additions` to the heat
    equation.

    Raises `InputError` where there can be no such temperatures, see `forward`.
    """
    found = recovered(with_fields(like, parameters))
    own = {name: (item.cells, item.faces) for name, item in found.items()}
    near, far = (
        properties(ready.stated, values, len(body.cells), len(body.faces))
        for body, values in ((ready.mesh, own), (mesh, carry_over(found, ready.mesh, mesh)))
    )
    tolerance = SHORTER * task.stepping.tolerance

    def solved(run: Run) -> Float[np.ndarray, "frames samples"]:
        where = f"{task.scene.folder}: runs.{run.name}.recording"
        # Planned where it costs little: how fast a body changes shows on the fit's mesh too.
        steps = free_grid(ready.mesh, near, run, tolerance=tolerance)
        return forward(
            mesh, task.meshing.order, run, {"here": far}, steps, where, additions
        ).temperature

    return at_once(solved, [task.runs[number] for number in like.sequence])


def finer_readings(
    task: Task,
    ready: Ready,
    like: Objective,
    temperatures: Sequence[Float[np.ndarray, "_frames _samples"]],
    additions: tuple[Addition, ...] = (),
) -> list[Float[np.ndarray, "runs frames samples"]]:
    """What is read [K] of `finer_temperatures` [K], laid out as the cases of `like`.

    NaN where a run has nothing. Effects on the readings, of all `additions` those that count here,
    ask for no other run of the body.
    """
    every = iter(zip(like.sequence, temperatures, strict=True))
    laid = [np.full(case.data.shape, np.nan) for case in like.cases]
    for case, rows in zip(like.cases, laid, strict=True):
        for number, row in enumerate(rows):
            which, body_at = next(every)
            run, samples = task.runs[which], body_at.shape[1]
            under = one_run(case.under, number)
            time, pinned = run.recording.time, np.asarray(case.pinned)[number, :samples]
            body, when, held = (jnp.asarray(one) for one in (body_at, time, pinned))
            read = np.asarray(read_now(body, when, under, held, additions))
            wanted = np.asarray(ready.grids[run.name].frame_time)
            row[: len(wanted), :samples] = read[np.searchsorted(run.recording.time, wanted - 1e-9)]
    return laid


@program
def _temperatures(objective: Objective) -> list[Float[Array, "runs frames samples"]]:
    return [
        jax.lax.map(lambda one: case_temperatures(objective, objective.fields, one), case)
        for case in objective.cases
    ]


def with_defects(objective: Objective, apart: Defects) -> Objective:
    """The objective with defects [K] in the order of its cases; tangents need none."""
    cases = [
        replace(case, defect=defect) for case, defect in zip(objective.cases, apart, strict=True)
    ]
    return replace(objective, cases=tuple(cases))


def with_remainders(objective: Objective, apart: Defects) -> Objective:
    """The objective with what is added to its readings, effects on them among them [K]."""
    cases = [replace(case, remainder=one) for case, one in zip(objective.cases, apart, strict=True)]
    return replace(objective, cases=tuple(cases))


def with_shared(objective: Objective) -> Objective:
    """The objective to which its defects [K] may still be wrong by a share that nobody knows.

    What the finer run is still wrong by is alike: a share of each run's defect, of mean zero and
    standard deviation a third, counts as an error that all its readings have in common.

    Source: Kennedy and O'Hagan, J. R. Statist. Soc. B 63 (2001) 425, a discrepancy of the model.
    """
    cases = (replace(case, shared=_in_common(case)) for case in objective.cases)
    return replace(objective, cases=tuple(cases))


@program
def _in_common(case: Case) -> Float[Array, "runs frames samples"]:
    return jax.vmap(whiten)(case.errors, case.used, DEFECT_LEFT * case.defect)


def defect_sizes(objective: Objective) -> dict[int, float]:
    """Root mean square of what is added [K] where there are readings, by number of the run."""
    defects = (np.asarray(one) for case in objective.cases for one in case.defect)
    return {
        number: float(np.sqrt(np.mean(defect[weight > 0] ** 2)))
        for (number, _, weight), defect in zip(run_parts(objective), defects, strict=True)
    }
