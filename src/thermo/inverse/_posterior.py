"""What the data leave open of fields, near the ones that a fit found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Float

from thermo.fields import QUANTITIES, departing_field, place_control_points
from thermo.inverse._body import Meshing, surface_of
from thermo.inverse._defect import less_defects, with_shared
from thermo.inverse._estimate import Estimate, RecoveredField, load_estimate
from thermo.inverse._evidence import Linearised, likely_steps
from thermo.inverse._field_choice import OnControlPoints
from thermo.inverse._field_loss import FieldLoss, field_loss
from thermo.inverse._field_posterior import FieldPosterior, Smoothness
from thermo.inverse._objective import Objective, run_parts
from thermo.inverse._properties import Stated
from thermo.inverse._sensitivity import unfitted
from thermo.inverse._smoothing import Choice, Nearby, linearised, with_choice
from thermo.inverse._stages import coarse_tangents, make_objective
from thermo.inverse._stepping import Stepping
from thermo.inverse._surface_scale import scale_slopes
from thermo.inverse._task import Prior, Ready, Task, lay_out
from thermo.inverse._transfer import check_same_object
from thermo.mesh import Mesh
from thermo.observe import Scene

CONTROLS = 300
"""Control points [1] on which fields may depart from an estimate."""


def posterior(
    data: Scene | str | Path,
    estimate: Estimate | str | Path,
    *,
    count: int = CONTROLS,
    runs: tuple[str, ...] | None = None,
    prior: Prior | None = None,
    stepping: Stepping | None = None,
    meshing: Meshing | None = None,
    seed: int = 0,
    model_error: float = 0.01,
) -> FieldPosterior:
    """What the runs that were fitted leave open of the fields (Laplace's approximation).

    The fields may depart from the estimate by a factor on control points of their own, more than a
    fit has: what the estimate could not follow is then part of its error. Around the estimate the
    simulation is taken as linear in log(phi). The weights of the runs are found as in a fit, and so
    is the probability of each smoothness, over all of which the result is summed: a smoothness
    that the data do not fix does not make a band narrow. A third of what `meshing.corrected` takes
    off counts as unknown, and so does what the scale of the surface leaves open. What was taken as
    linear is kept under the most probable smoothness (`loss`): `thermo.identify.region_profile`.

    Arguments:

    - `data`: the scene, or its folder.
    - `estimate`: the result of `invert`, or the folder that `thermo invert` left.
    - `count`: control points [1]; `seed`: of the first of them.
    - `runs`, `prior`, `stepping`, `meshing`, `model_error` [K]: as they were given to `invert`.
      Slopes are those of coarse cells and steps unless `meshing.coarse_tangents` is false.

    Raises `InputError` as `invert` does, and where the estimate cannot be read or is of another
    object.

    Source: D. J. C. MacKay, Neural Computation 4 (1992) 415, sections 3 and 4; Bui-Thanh, Ghattas,
    Martin and Stadler, SIAM J. Sci. Comput. 35 (2013) A2494, section 4.
    """
    where, mesh, order, stated, found = _parts(estimate)
    values = {name: float(np.median(item.faces)) for name, item in found.items()}
    task = unfitted(
        data, runs, tuple(found), OnControlPoints(count), prior or Prior(), stepping, meshing,
        values, seed=seed, model_error=model_error,
    )  # fmt: skip
    check_same_object(mesh, surface_of(task.scene), where)
    ready = lay_out(task, mesh, stated)
    fields, points = {}, {}
    for number, (name, item) in enumerate(found.items()):
        controls = place_control_points(mesh, count, seed=seed + number)
        fields[name] = departing_field(QUANTITIES[name], mesh, controls, item.cells, item.faces)
        points[name] = controls.points
    ready = replace(ready, fields=dict(fields))
    objective = make_objective(task, ready, order)
    if task.meshing.coarse_tangents is not False:
        objective = replace(objective, tangents=coarse_tangents(task, ready))
    if task.meshing.corrected:
        objective = less_defects(task, ready, objective)
    near = linearised(objective, [run.recording.points for run in task.runs])
    pulls = _all_pulls(task, ready, objective, near.slopes)
    mixture, shift = _in_logarithms(objective, near, prior, pulls)
    parts = (mixture, shift, _loss(objective, near, mixture))
    return FieldPosterior(mesh, order, stated, fields, points, *parts)


def _loss(objective: Objective, near: Nearby, mixture: list[Smoothness]) -> FieldLoss:
    """What a fit would make small, as smooth as the data ask for and with their weights."""
    likely = max(mixture, key=lambda one: one.weight)
    chosen = with_choice(replace(objective, tangents=None), Choice(likely.steps, near.weights))
    return field_loss(chosen, likely.move, np.linalg.inv(likely.covariance))


def _parts(
    estimate: Estimate | str | Path,
) -> tuple[str, Mesh, int, Stated, dict[str, RecoveredField]]:
    if isinstance(estimate, Estimate):
        where = "estimate"
        mesh, order, stated, fields = (
            estimate.mesh, estimate.order, estimate.stated, estimate.fields
        )  # fmt: skip
    else:
        path = Path(estimate) / "estimate.npz"
        where, (mesh, order, stated, fields) = str(path), load_estimate(path)
    # Columns of a Jacobian are in the order of the alphabet, whatever the order of the fields.
    return where, mesh, order, stated, dict(sorted(fields.items()))


def _in_logarithms(
    objective: Objective,
    near: Nearby,
    prior: Prior | None,
    pulls: Float[np.ndarray, "unknowns causes"],
) -> tuple[list[Smoothness], Float[np.ndarray, "unknowns causes"]]:
    """The distributions of log(phi) at the controls, and what each cause that pulls moves."""
    fit, before = _with_even_spread(objective, near)
    step = None if prior is None else prior.step
    tried = likely_steps(fit) if step is None else [(dict.fromkeys(fit.rough, step), 1.0)]
    mixture, shift = [], np.zeros_like(pulls)
    for steps, weight in tried:
        move, curvature = fit.solve(steps)
        covariance = np.linalg.inv(curvature)
        belief = np.linalg.inv(replace(fit, information=before).solve(steps)[1])
        shift += weight * covariance @ pulls
        mixture.append(Smoothness(steps, weight, move, covariance, belief))
    return mixture, shift


def _with_even_spread(
    objective: Objective, near: Nearby
) -> tuple[Linearised, Float[np.ndarray, "unknowns unknowns"]]:
    """The fit whose means lie within what is physical, and the information of its beliefs alone.

    An even spread over the bounds stands in where nothing is believed of a field's mean. It pulls
    nowhere, and without it there would be no share of a prior that the data take away.
    """
    beliefs, begin = np.zeros_like(near.beliefs), 0
    for name, field in objective.fields.items():
        count = len(np.asarray(field.control_values()))
        row = np.zeros(len(beliefs))
        row[begin : begin + count] = 1 / count
        begin += count
        if not np.isfinite(float(objective.priors[name].spread)):
            spread = np.log(field.quantity.upper / field.quantity.lower) / np.sqrt(12)
            beliefs += np.outer(row, row) / spread**2
    wide = replace(near.fit, information=near.fit.information + beliefs)
    return wide, near.beliefs + beliefs


def _all_pulls(
    task: Task, ready: Ready, objective: Objective, slopes: Float[np.ndarray, "values unknowns"]
) -> Float[np.ndarray, "unknowns causes"]:
    """What `_pulls` says, and of one deviation of the surface's scale where it is not exact [1]."""
    pulls, deviation = _pulls(objective, slopes), task.scene.scale_deviation
    if deviation == 0.0:
        return pulls
    along = scale_slopes(task, ready, objective)[: len(slopes)]
    return np.column_stack([pulls, deviation * slopes.T @ along])


def _pulls(
    objective: Objective, slopes: Float[np.ndarray, "values unknowns"]
) -> Float[np.ndarray, "unknowns runs"]:
    """Slopes of half the sum of squares for what cells and steps may still make wrong [1]."""
    left = with_shared(objective)
    shared = (np.asarray(one).ravel() for case in left.cases for one in case.shared)
    pulls = np.zeros((slopes.shape[1], len(objective.sequence)))
    for (run, part, _), apart in zip(run_parts(objective), shared, strict=True):
        pulls[:, run] = slopes[part].T @ apart
    return pulls
