"""From recordings to fields."""

from __future__ import annotations

import hashlib
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from thermo.fields import QUANTITIES, AbstractField, cell_values, face_values
from thermo.inverse._body import (
    Meshing,
    check_initial,
    duration,
    make_mesh,
    of_order,
    scan_conductivity,
    state,
    surface_of,
)
from thermo.inverse._case import make_case, stack_cases
from thermo.inverse._conditions import conditions, make_model, switches
from thermo.inverse._estimate import Estimate, RecoveredField, RunFit
from thermo.inverse._field_choice import AbstractFieldChoice, Uniform
from thermo.inverse._least_squares import LevenbergMarquardt
from thermo.inverse._minimise import Fit, OnStep, minimise
from thermo.inverse._objective import FieldPrior, Objective, case_temperatures, with_fields
from thermo.inverse._optimiser import AbstractOptimiser
from thermo.inverse._properties import Stated, check_unknowns, properties
from thermo.inverse._selection import select_fit_runs, select_unknowns
from thermo.mesh import Mesh, resolution
from thermo.observe import Run, Scene, read_scene
from thermo.physics import ConjugateGradient, TimeGrid, discretise, plan_steps, uniform_steps
from thermo.physics.integrators import AbstractIntegrator, BackwardEuler, Sdirk2


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


@final
@dataclass(frozen=True)
class Stepping:
    """How time is cut into steps.

    - `integrator`: the scheme. A first-order one takes steps of `size` [s]; a second-order one
      plans its steps for `tolerance` [K] an error a step.
    - `most_frames`: about the most frames of a run that are fitted [1].
    - `rtol`: of the linear solver, relative to each step's own change [1].
    - `lagged`: the paper's lagged radiation.
    """

    integrator: AbstractIntegrator = field(default_factory=Sdirk2)
    size: float = 0.1
    tolerance: float = 5e-3
    most_frames: int = 120
    rtol: float = 1e-5
    lagged: bool = False


def fit_grid(mesh: Mesh, stated: Stated, run: Run, stepping: Stepping) -> TimeGrid:
    """Steps [s] of a run's simulation, planned on the linear mesh, and the frames that they fit."""
    frames = run.recording.time
    if isinstance(stepping.integrator, BackwardEuler):
        return uniform_steps(frames, stepping.size, switches(run))
    space = discretise(mesh)
    body = properties(stated, {}, len(mesh.cells), len(mesh.faces))
    under = conditions(run, space)
    return plan_steps(
        make_model(space, body, under),
        under.start(len(space.mesh.nodes)),
        frames,
        tolerance=stepping.tolerance,
        largest=float(frames[-1]) / stepping.most_frames * 2,
        switches=switches(run),
        every_frame=False,
    )


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


def _key(*parts: object) -> str:
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def invert(
    data: Scene | str | Path,
    *,
    runs: tuple[str, ...] | None = None,
    unknown: tuple[str, ...] | None = None,
    choice: AbstractFieldChoice | None = None,
    optimiser: AbstractOptimiser | None = None,
    prior: Prior | None = None,
    stepping: Stepping | None = None,
    meshing: Meshing | None = None,
    stages: Literal["none", "tet4_tet10"] = "none",
    initial: dict[str, float] | None = None,
    seed: int = 0,
    model_error: float = 0.01,
    checkpoint: Path | None = None,
    on_step: OnStep | None = None,
) -> Estimate:
    """Recover fields of an object from recordings of its surface temperature.

    Minimises 1/2 sum ((T_sim - T_meas) / sd)^2 over all runs, samples and frames, plus priors,
    over fields that all runs share.

    Arguments:

    - `data`: a scene, or the folder of one. Its `truth` is never read.
    - `runs`: names of the runs to fit; all that are not held out by default.
    - `unknown`: quantities to find; the scene's own by default.
    - `choice`: how they vary over the object; `prior`: how smoothly.
    - `optimiser`, `stepping`, `meshing`: with their own units.
    - `stages`: "tet4_tet10" fits on linear cells first, then on quadratic ones from that field.
    - `initial`: first values by quantity [SI]; the stated ones by default. A conductivity that
      nobody states is first found to a factor three by a scan on a coarse mesh.
    - `seed`: of control points and networks.
    - `model_error`: what the simulation may be wrong by, added to the noise [K].
    - `checkpoint`: file that an interrupted fit goes on from.
    - `on_step`: told of every step.

    Raises `InputError` for input that cannot be used, before any work is done.

    Source: paper, section 4.3 (checklist E1 to E7).
    """
    begun = time.monotonic()
    scene = data if isinstance(data, Scene) else read_scene(Path(data))
    picked = select_fit_runs(scene, runs)
    names = select_unknowns(scene, unknown)
    check_unknowns(names, scene)
    initial = {} if initial is None else initial
    check_initial(initial)
    choice = Uniform() if choice is None else choice
    optimiser = LevenbergMarquardt() if optimiser is None else optimiser
    prior = Prior() if prior is None else prior
    stepping = Stepping() if stepping is None else stepping
    meshing = Meshing() if meshing is None else meshing

    surface = surface_of(scene)
    guess = 1.0
    if scene.material.conductivity is None and not {"conductivity", "diffusivity"} & set(initial):
        guess = scan_conductivity(scene, surface, picked, meshing)
    stated = state(scene, initial, guess)
    mesh = make_mesh(scene, surface, stated.of("diffusivity"), meshing)
    fields, pairs = {}, {}
    for number, name in enumerate(names):
        made = choice.make(QUANTITIES[name], mesh, stated.of(name), seed + number)
        fields[name], pairs[name] = made
    priors = _priors(fields, pairs, stated, scene, prior)
    grids = {run.name: fit_grid(mesh, stated, run, stepping) for run in picked}

    def objective(order: int) -> Objective:
        space = discretise(of_order(mesh, order))
        cases = [
            make_case(
                run,
                space,
                grids[run.name],
                model_error=model_error,
                where=f"{scene.folder}: runs.{run.name}.recording",
            )
            for run in picked
        ]
        solver = ConjugateGradient(rtol=stepping.rtol)
        return Objective(
            space,
            stated,
            fields,
            priors,
            stack_cases(cases),
            stepping.integrator,
            solver,
            stepping.lagged,
        )

    orders = [1, 2] if stages == "tet4_tet10" else [meshing.order]
    key = _key(str(scene.folder), [r.name for r in picked], names, choice, optimiser, prior,
               stepping, replace(meshing, cache=None), stages, sorted(initial.items()), seed,
               model_error)  # fmt: skip
    fit = minimise(
        [lambda order=order: objective(order) for order in orders],
        optimiser,
        key=key,
        checkpoint=checkpoint,
        on_step=on_step,
    )
    last = objective(orders[-1])
    found = with_fields(last, fit.parameters)
    sentence = resolution(
        mesh, diffusivity=_median_diffusivity(stated, found), duration=duration(scene)
    ).describe()
    return Estimate(
        mesh=mesh,
        order=orders[-1],
        stated=stated,
        fields=_recovered(found),
        runs=_run_fits(last, fit, picked, grids),
        history=fit.history,
        success=fit.success,
        seconds=time.monotonic() - begun,
        resolution=sentence,
    )


def _median_diffusivity(stated: Stated, found: dict[str, AbstractField]) -> float:
    body = {name: float(jnp.median(cell_values(item))) for name, item in found.items()}
    if "diffusivity" in body:
        return body["diffusivity"]
    conductivity = body.get("conductivity", stated.conductivity)
    return conductivity / body.get("volumetric_heat_capacity", stated.capacity)


def _recovered(found: dict[str, AbstractField]) -> dict[str, RecoveredField]:
    return {
        name: RecoveredField(
            name,
            item.quantity.unit,
            np.asarray(cell_values(item)),
            np.asarray(face_values(item)),
        )
        for name, item in found.items()
    }


@eqx.filter_jit
def _temperatures(objective: Objective, fields: dict[str, AbstractField]) -> list[jax.Array]:
    return [
        jax.lax.map(lambda one: case_temperatures(objective, fields, one), case)
        for case in objective.cases
    ]


def _run_fits(
    objective: Objective, fit: Fit, runs: list[Run], grids: dict[str, TimeGrid]
) -> dict[str, RunFit]:
    fields = with_fields(objective, fit.parameters)
    simulated = [np.asarray(one) for group in _temperatures(objective, fields) for one in group]
    measured = [np.asarray(one) for case in objective.cases for one in case.data]
    weights = [np.asarray(one) for case in objective.cases for one in case.weight]
    order = _order_of_runs(runs)
    result = {}
    for place, run in zip(order, runs, strict=True):
        frames, samples = len(grids[run.name].frame_time), len(run.recording.points)
        cut = (slice(0, frames), slice(0, samples))
        valid = weights[place][cut] > 0
        data = np.where(valid, measured[place][cut], np.nan)
        here = simulated[place][cut]
        result[run.name] = RunFit(
            rmse=float(np.sqrt(np.nanmean((here - data) ** 2))),
            time=np.asarray(grids[run.name].frame_time),
            points=run.recording.points,
            measured=data,
            simulated=here,
        )
    return result


def _order_of_runs(runs: list[Run]) -> list[int]:
    """Place of each run in the stacked groups, which keep runs of equal structure together."""
    kinds: dict[tuple, list[int]] = {}
    for number, run in enumerate(runs):
        shape = tuple(len(item.time) for item in run.prescribed)
        kinds.setdefault(shape, []).append(number)
    sequence = [number for group in kinds.values() for number in group]
    return [sequence.index(number) for number in range(len(runs))]
