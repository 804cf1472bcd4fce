"""How recorded temperatures change with what is unknown, before anything is fitted."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import final

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float

from thermo._compiled import make_room
from thermo.errors import InputError
from thermo.inverse._body import Meshing
from thermo.inverse._case import common_deviations, constant_error, in_kelvin
from thermo.inverse._field_choice import AbstractFieldChoice, Uniform
from thermo.inverse._first_order import Adam
from thermo.inverse._objective import (
    Objective,
    Parameters,
    run_parts,
    start,
    with_fields,
)
from thermo.inverse._scale import SCALES, scaled_slopes
from thermo.inverse._stages import make_objective
from thermo.inverse._stepping import Stepping
from thermo.inverse._surface_scale import scale_slopes
from thermo.inverse._task import Prior, Task, prepare, what_is_asked
from thermo.observe import Scene


@final
@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of the temperatures by the logarithms of the unknowns' values at their controls.

    - `names`: quantity or factor of each column, (unknowns,).
    - `slopes`: by run, dT / d log(phi), (frames, samples, unknowns) [K]; zero without a reading.
    - `noise`: by run, standard deviation of a reading, wider where frames are correlated [K].
    - `accuracy`: tolerance of the solver that the slopes come from, relative [1].
    - `staying`: by run, standard deviation of what is not known of a sample's constant error [K].
    - `common`: by run, what all samples of a frame have in common, each frame by itself, and what
      all readings have, standard deviations [K]; runs that have nothing in common may be left out.
    - `values`: of the unknowns, where the slopes were taken, (unknowns,) [SI].
    - `defect`: by run, what cells and steps still make wrong in all readings at once, its size
      known and not its sign, (frames, samples) [K]; empty where that was not measured.
    - `scale`: by run, dT / d log(scale of the surface), (frames, samples) [K], and
      `scale_deviation`: its standard deviation [1]; empty and 0 where the scale is exact.
    """

    names: tuple[str, ...]
    slopes: dict[str, Float[np.ndarray, "frames samples unknowns"]]
    noise: dict[str, float]
    accuracy: float = 0.0
    staying: dict[str, float] = field(default_factory=dict)
    values: tuple[float, ...] = ()
    defect: dict[str, Float[np.ndarray, "frames samples"]] = field(default_factory=dict)
    scale: dict[str, Float[np.ndarray, "frames samples"]] = field(default_factory=dict)
    scale_deviation: float = 0.0
    common: dict[str, tuple[float, float]] = field(default_factory=dict)


def sensitivity(
    data: Scene | str | Path,
    *,
    runs: tuple[str, ...] | None = None,
    unknown: tuple[str, ...] | None = None,
    choice: AbstractFieldChoice | None = None,
    stepping: Stepping | None = None,
    meshing: Meshing | None = None,
    initial: dict[str, float] | None = None,
    seed: int = 0,
    scales: tuple[str, ...] = (),
) -> Sensitivity:
    """Slopes of the recorded temperatures [K] at the values that the scene states.

    Arguments as for `invert`; `choice` is one value for the body by default. `scales` are factors
    that may be wrong as well [1]: "heater_power", on the power of all lamps, and
    "camera_emissivity", on what is read above the temperature that the body reflects. The
    temperatures of the recordings are not used, unless a conductivity that nobody states is to be
    found: then to choose one roughly. Raises `InputError` as `invert` does.
    """
    _check_scales(scales)
    task = unfitted(
        data, runs, unknown, choice or Uniform(), Prior(), stepping, meshing, initial,
        seed=seed, model_error=0.0,
    )  # fmt: skip
    ready = prepare(task)
    objective = make_objective(task, ready, task.meshing.order)
    objective = replace(objective, cases=tuple(in_kelvin(case) for case in objective.cases))
    here = start(objective)
    # Asked first: the Jacobian by the many weights of a network would take for ever.
    change = logarithm_slopes(objective, here, tuple(objective.fields), type(task.choice).__name__)
    matrix = np.array(scaled_slopes(objective, scales))
    matrix[:, : len(change)] = matrix[:, : len(change)] @ np.linalg.inv(change)
    found = _by_run(objective, matrix, task, scales)
    if task.scene.scale_deviation == 0.0:
        return found
    return _with_scale(found, objective, scale_slopes(task, ready, objective), task)


def _check_scales(scales: tuple[str, ...]) -> None:
    for name in scales:
        if name not in SCALES:
            raise InputError(
                "there is no such factor", where="scales", value=name, limit=", ".join(SCALES),
                remedy="leave it out",
            )  # fmt: skip


def unfitted(
    data: Scene | str | Path,
    runs: tuple[str, ...] | None,
    unknown: tuple[str, ...] | None,
    choice: AbstractFieldChoice,
    prior: Prior,
    stepping: Stepping | None,
    meshing: Meshing | None,
    initial: dict[str, float] | None,
    *,
    seed: int = 0,
    model_error: float,
) -> Task:
    """What would be asked of a fit, checked as `invert` does; arguments as there, errors in [K]."""
    make_room()
    scene, picked, names, initial = what_is_asked(data, runs, unknown, initial)
    # No optimiser steps here; any that takes no tangents of its own will do.
    how = (choice, Adam(), prior, stepping or Stepping(), meshing or Meshing())
    return Task(scene, picked, names, *how, "none", initial, seed, model_error)


def logarithm_slopes(
    objective: Objective, parameters: Parameters, names: tuple[str, ...], choice: str
) -> Float[np.ndarray, "controls unknowns"]:
    """Slopes of the logarithms at the controls, field by field as named, by their parameters [1].

    The objective's own order is no guide: a compiled function returns fields by the alphabet.

    Raises `InputError`, which names the `choice`, where there is not one unknown for each control.
    """
    flat, unravel = ravel_pytree(parameters)

    def logarithms(point: Float[Array, " unknowns"]) -> Float[Array, " controls"]:
        fields = with_fields(objective, unravel(point))
        return jnp.concatenate([jnp.log(fields[name].control_values()) for name in names])

    if jax.eval_shape(logarithms, flat).shape != flat.shape:
        raise InputError(
            "this field has other unknowns than the values at its control points",
            where="choice",
            value=choice,
            limit="one unknown a control point",
            remedy="give Uniform, Patchwise or OnControlPoints",
        )
    return np.asarray(jax.jacfwd(logarithms)(flat))


def _by_run(
    objective: Objective, matrix: np.ndarray, task: Task, scales: tuple[str, ...]
) -> Sensitivity:
    slopes, noise, staying, common = {}, {}, {}, {}
    for number, part, weight in run_parts(objective):
        run = task.runs[number]
        here = matrix[part].reshape(*weight.shape, -1)
        slopes[run.name] = here[:, : len(run.recording.points)]
        found = run.noise_of_readings()
        noise[run.name] = found.long_run()
        staying[run.name] = float(np.sqrt(np.mean(constant_error(run, found)[1])))
        common[run.name] = common_deviations(run, found)
    values = {name: one.control_values() for name, one in objective.fields.items()}
    columns = tuple(name for name, each in values.items() for _ in range(each.size))
    return Sensitivity(
        names=(*columns, *scales),
        slopes=slopes,
        noise=noise,
        accuracy=task.stepping.rtol,
        staying=staying,
        common=common,
        values=(*(float(one) for each in values.values() for one in each), *(1.0 for _ in scales)),
    )


def _with_scale(
    found: Sensitivity, objective: Objective, slopes: Float[np.ndarray, " all"], task: Task
) -> Sensitivity:
    scale = {}
    for number, part, weight in run_parts(objective):
        run = task.runs[number]
        scale[run.name] = slopes[part].reshape(weight.shape)[:, : len(run.recording.points)]
    return replace(found, scale=scale, scale_deviation=task.scene.scale_deviation)
