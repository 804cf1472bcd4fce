"""From recordings to fields."""

from __future__ import annotations

import functools
import time
from collections.abc import Iterable, Mapping
from itertools import combinations
from pathlib import Path
from typing import Literal

import numpy as np

from thermo._compiled import make_room
from thermo._say import Say
from thermo.errors import InputError
from thermo.fields import AbstractField, TwoMaterialField
from thermo.inverse._body import Meshing, duration
from thermo.inverse._estimate import Estimate, RunFit, recovered
from thermo.inverse._field_choice import AbstractFieldChoice, OnControlPoints, TwoMaterials
from thermo.inverse._finer_mesh import finer_mesh_ahead
from thermo.inverse._least_squares import LevenbergMarquardt
from thermo.inverse._minimise import OnStep, minimise
from thermo.inverse._objective import with_fields
from thermo.inverse._optimiser import AbstractOptimiser
from thermo.inverse._properties import diffusivity_quantile
from thermo.inverse._run_fit import run_fits
from thermo.inverse._scale_effect import scale_remarks
from thermo.inverse._smoothing import ALL_BUT_UNIFORM
from thermo.inverse._stages import corrected, data_choose, make_stage, stage_orders
from thermo.inverse._stepping import Stepping
from thermo.inverse._surface_scale import scale_effect
from thermo.inverse._task import Prior, Task, prepare, what_is_asked
from thermo.mesh import resolution
from thermo.observe import Run, Scene


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
    stages: Literal["none", "tet4_tet10"] = "tet4_tet10",
    initial: dict[str, float] | None = None,
    start: float = 1.0,
    seed: int = 0,
    model_error: float = 0.01,
    checkpoint: Path | None = None,
    on_step: OnStep | None = None,
    say: Say = lambda words: None,
) -> Estimate:
    """Recover fields of an object from recordings of its surface temperature.

    Minimises 1/2 |L^-1 (T_sim - T_meas)|^2 over all runs, L L' the covariance of the readings'
    errors, plus priors, over fields that all runs share. Where the scene states how well the scale
    of its surface is known (`scale_deviation`), the result says what that leaves open.

    Arguments:

    - `data`: a scene, or the folder of one. Its `truth` is never read.
    - `runs`: names of the runs to fit; all that are not held out by default.
    - `unknown`: quantities to find; the scene's own by default.
    - `choice`: how they vary over the object, control points by default; `prior`: how smoothly.
    - `optimiser`, `stepping`, `meshing`: with their own units.
    - `stages`: "tet4_tet10" fits on linear cells first, then on quadratic ones from that field,
      where `meshing` asks for quadratic ones.
    - `initial`: by quantity [SI], in place of what the scene states: first values of unknowns,
      and values of the rest. An unknown conductivity that nobody states is first found to a
      factor three by a scan on a coarse mesh.
    - `start`: factor on the first values of the unknowns [1], to see whether other starts end
      elsewhere; mesh and priors stay those of the values themselves.
    - `seed`: of control points and networks.
    - `model_error`: what the simulation may be wrong by, added to the noise [K].
    - `checkpoint`: file that an interrupted fit goes on from; remove it once the result is safe.
    - `on_step`: told of every step.
    - `say`: told of what comes before the first one.

    Raises `InputError` for input that cannot be used, before any work is done.

    Source: paper, section 4.3 (checklist E1 to E7).
    """
    begun = time.monotonic()
    make_room()
    scene, fitted, names, initial = what_is_asked(data, runs, unknown, initial)
    _check_start(start)
    how = (choice or OnControlPoints(), optimiser or LevenbergMarquardt(), prior or Prior())
    cut = (stepping or Stepping(), meshing or Meshing())
    task = Task(scene, fitted, names, *how, *cut, stages, initial, seed, model_error, start)
    return _fit(task, checkpoint, on_step, say, begun)


def _check_start(start: float) -> None:
    if not (np.isfinite(start) and start > 0):
        raise InputError(
            "a start is no factor", where="start", value=start, limit="a finite number above 0",
            remedy="give 0.3 or 3, for example",
        )  # fmt: skip


def _fit(
    task: Task, checkpoint: Path | None, on_step: OnStep | None, say: Say, begun: float
) -> Estimate:
    again = f"going on from {checkpoint}, if it is of this fit"
    known = checkpoint is not None and checkpoint.exists()
    say(f"{again if known else f'fitting {task.scene.object}'}: meshing")
    ready = prepare(task)
    say(f"compiling for a mesh of {len(ready.mesh.nodes)} nodes; the first step waits for it")
    orders = stage_orders(task, ready)
    with finer_mesh_ahead(task, ready) as finer:
        make = functools.partial(make_stage, task, ready, finer=finer)
        fit = minimise(
            [functools.partial(make, number) for number in range(len(orders))],
            task.optimiser,
            key=task.key(),
            checkpoint=checkpoint,
            on_step=on_step,
        )
    found = with_fields(fit.objective, fit.parameters)
    values = {name: (item.cell_values(), item.face_values()) for name, item in found.items()}
    diffusivity = diffusivity_quantile(ready.stated, values, len(ready.mesh.cells), 0.5)
    resolved = resolution(ready.mesh, diffusivity=diffusivity, duration=duration(task.scene))
    priors = fit.objective.priors
    smoothness = {name: float(p.step) for name, p in priors.items() if len(p.pairs)}
    met = run_fits(fit, task.runs, ready.grids)
    scale = scale_effect(task, ready, fit)
    return Estimate(
        mesh=ready.mesh,
        order=orders[-1],
        stated=ready.stated,
        fields=recovered(found),
        runs=met,
        history=fit.history,
        success=fit.success,
        seconds=time.monotonic() - begun,
        resolution=resolved.describe(),
        smoothness=smoothness,
        remarks=(
            *_one_material(task, found),
            *(_chosen(smoothness) if data_choose(task, ready) else ()),
            *_taken_off(task, met),
            *_unexplained(task, met),
            *_twice(task.runs),
            *at_bounds(found),
            *_unmoved(ready.fields, found),
            *scale_remarks(scale),
        ),
        scale=scale,
    )


def _one_material(task: Task, found: dict[str, AbstractField]) -> list[str]:
    return [
        f"The first stage shows one material in {name}: it was fitted on control points."
        for name, item in found.items()
        if isinstance(task.choice, TwoMaterials) and not isinstance(item, TwoMaterialField)
    ]


def _chosen(smoothness: dict[str, float]) -> list[str]:
    return [
        f"The data show no variation of {name} over the surface."
        if step <= ALL_BUT_UNIFORM
        else f"The data ask for a {name} that differs by a factor of about {np.exp(step):.3g} "
        "from one control point to the next."
        for name, step in smoothness.items()
    ]


def _taken_off(task: Task, met: dict[str, RunFit]) -> list[str]:
    if not any(run.defect for run in met.values()):
        failed = (
            "A mesh twice as fine could not be made, so that what the fit's cells and steps make "
            "wrong is not allowed for: simplify the surface, or lower mesh.max_nodes."
        )
        return [failed] if corrected(task) else []
    words = ", ".join(f"{run.defect:.2g} K in {name}" for name, run in met.items())
    return [
        f"What the fit's cells and steps make wrong is allowed for (mesh.corrected): {words} (RMS)."
    ]


# Share of a bound within which a value counts as there, and of values that are told of [1].
_THERE, _SOME = 0.05, 0.1


def at_bounds(found: Mapping[str, AbstractField]) -> list[str]:
    """Remarks on fields [SI] of which some came to a bound; an emissivity may well be one."""
    told = []
    for name, item in found.items():
        quantity, values = item.quantity, np.asarray(item.control_values())
        there = {
            quantity.lower: values < quantity.lower * (1 + _THERE),
            quantity.upper: (values > quantity.upper * (1 - _THERE)) & (name != "emissivity"),
        }
        told += [
            f"{100 * np.mean(some):.0f} % of {name} came to its bound, {bound:g} {quantity.unit}: "
            "look at the units of what is stated, and at what else may be wrong."
            for bound, some in there.items()
            if np.mean(some) >= _SOME
        ]
    return told


# Relative change [1] of a value that nothing pushed.
_STILL = 1e-9


def _unmoved(first: Mapping[str, AbstractField], found: Mapping[str, AbstractField]) -> list[str]:
    """Remarks on fields [SI] that are where they began."""
    return [
        f"{name} stayed at its first value: these readings do not change with it, or it was right "
        "from the start. `thermo identify` tells which."
        for name, item in found.items()
        if np.allclose(item.cell_values(), first[name].cell_values(), rtol=_STILL, atol=0.0)
        and np.allclose(item.face_values(), first[name].face_values(), rtol=_STILL, atol=0.0)
    ]


def _twice(runs: Iterable[Run]) -> list[str]:
    """Remarks on runs whose readings are the same, which noise does not do."""
    return [
        f"{one.name} and {other.name} hold the same readings, which count twice: leave one out."
        for one, other in combinations(runs, 2)
        if np.array_equal(one.recording.temperature, other.recording.temperature, equal_nan=True)
    ]


UNEXPLAINED = 2.0
"""Residual over noise and model error [1] from which a run is said not to be explained."""


def _unexplained(task: Task, met: dict[str, RunFit]) -> list[str]:
    ratios = {
        name: run.rmse / float(np.hypot(run.noise, task.model_error)) for name, run in met.items()
    }
    runs = {run.name: run for run in task.runs}
    return [
        f"The residual of {name} is {ratio:.2g} times its noise with model_error: this field or "
        "this model does not explain the recording. `thermo discover` looks for what is missing."
        f"{_flash(runs[name])}"
        for name, ratio in ratios.items()
        if ratio > UNEXPLAINED
    ]


def _flash(run: Run) -> str:
    """What to look at where a lamp is off before it could be seen."""
    time = run.recording.time
    if run.heater is None or len(time) < 2 or run.heater.until > time[1]:
        return ""
    return f" Its lamp is off at {run.heater.until:g} s, before the second frame, at {time[1]:g} s."
