"""What a surface whose scale is known roughly does to a fit."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float

from thermo._compiled import program
from thermo.inverse._minimise import Fit
from thermo.inverse._objective import Objective, jacobian, residual, start, with_fields
from thermo.inverse._scale_effect import ScaleEffect
from thermo.inverse._stages import MOST_UNKNOWNS, plain_objective
from thermo.inverse._task import Ready, Task
from thermo.mesh import face_areas
from thermo.observe import Box, Run

STEP: Final = 1e-3
"""By how much the logarithm of the scale goes up and down for a central difference [1]."""

TIGHT: Final = 1e-8
"""Relative tolerance of the linear solver there [1]: its errors count over twice that step."""


def scale_slopes(task: Task, ready: Ready, objective: Objective) -> Float[np.ndarray, " all"]:
    """Slopes of the residual by the logarithm of the surface's scale [1], zero for priors.

    Everything that is given in the coordinates of the surface scales with it about their origin:
    the nodes, the samples that lie on it, axis and spot of the lamp, the boxes of prescribed
    temperatures and of insulation. Powers [W], times [s] and temperatures [K] do not, and neither
    do the steps: what is left is the slope of the same discrete simulation.

    Arguments: `ready`: what `objective` was made of; its fields are taken where they stand.
    """
    there = (_scaled(task, ready, objective, float(np.exp(way * STEP))) for way in (1, -1))
    more, less = (program(residual)(one, start(objective)) for one in there)
    return np.asarray((more - less) / (2 * STEP))


def _scaled(task: Task, ready: Ready, objective: Objective, factor: float) -> Objective:
    mesh = replace(ready.mesh, nodes=factor * ready.mesh.nodes)
    task = replace(task, runs=tuple(_scaled_run(run, factor) for run in task.runs))
    order, rtol = objective.space.mesh.order, min(task.stepping.rtol, TIGHT)
    made = plain_objective(task, replace(ready, mesh=mesh), order, ready.steps, rtol)
    cases = tuple(
        replace(case, under=other.under, readout=other.readout)
        for case, other in zip(objective.cases, made.cases, strict=True)
    )
    return replace(objective, space=made.space, cases=cases, solver=made.solver, tangents=None)


def _scaled_run(run: Run, factor: float) -> Run:
    recording, heater = run.recording, run.heater
    if heater is not None:
        heater = replace(heater, centre=factor * heater.centre, radius=factor * heater.radius)
    return replace(
        run,
        recording=eqx.tree_at(lambda one: one.points, recording, factor * recording.points),
        heater=heater,
        prescribed=tuple(
            replace(one, box_min=factor * one.box_min, box_max=factor * one.box_max)
            for one in run.prescribed
        ),
        air=tuple(replace(one, box=_scaled_box(one.box, factor)) for one in run.air),
        insulated=tuple(_scaled_box(box, factor) for box in run.insulated),
    )


def _scaled_box(box: Box, factor: float) -> Box:
    return Box(factor * box.low, factor * box.high)


def scale_effect(task: Task, ready: Ready, fit: Fit) -> ScaleEffect | None:
    """What the stated deviation of the scale does to the values that a fit found.

    With J the slopes of the whitened residual, priors and all, by the parameters and g those by
    the logarithm of the scale, the fit moves by d = -(J'J)^-1 J'g a unit of it, and the covariance
    (J'J)^-1 gains s^2 d d'. J is that of the coarse tangents where these led the fit.

    None where the scale is exact, and where there are too many parameters for a dense J.
    """
    deviation = task.scene.scale_deviation
    flat, unravel = ravel_pytree(fit.parameters)
    if deviation == 0.0 or flat.size > MOST_UNKNOWNS:
        return None
    objective = replace(fit.objective, fields=with_fields(fit.objective, fit.parameters))
    steep = fit.objective if fit.objective.tangents is None else fit.objective.tangents
    _, matrix = program(jacobian)(steep, fit.parameters)
    # Bounded, so that a direction which nothing fixes does not carry rounding into all others.
    inverse = np.linalg.pinv(np.asarray(matrix), rcond=1e-10)
    moved = -inverse @ scale_slopes(task, ready, objective)
    areas = jnp.asarray(face_areas(ready.mesh))

    def means(point: Float[Array, " unknowns"]) -> dict[str, Float[Array, ""]]:
        found = with_fields(fit.objective, unravel(point))
        return {
            name: jnp.log(item.face_values()) @ areas / areas.sum() for name, item in found.items()
        }

    rows = {name: np.asarray(row) for name, row in jax.jacfwd(means)(flat).items()}
    change = {name: float(row @ moved) for name, row in rows.items()}
    without = {name: float(np.linalg.norm(row @ inverse)) for name, row in rows.items()}
    return ScaleEffect(deviation, change, without)
