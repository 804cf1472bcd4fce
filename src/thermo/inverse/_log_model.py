"""A scene as a function: logarithms of a few values in, whitened residual and Jacobian out."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np
from jaxtyping import Float

from thermo._compiled import program
from thermo.errors import InputError
from thermo.fields import QUANTITIES
from thermo.inverse._body import Meshing
from thermo.inverse._defect import less_defects, with_shared
from thermo.inverse._field_choice import Uniform
from thermo.inverse._objective import Objective, jacobian
from thermo.inverse._sensitivity import logarithm_slopes, unfitted
from thermo.inverse._stages import make_objective
from thermo.inverse._stepping import Stepping
from thermo.inverse._task import Prior, prepare
from thermo.mesh import Mesh
from thermo.observe import Scene


@final
@dataclass(frozen=True)
class LogModel:
    """Residuals of all runs and priors as a function of log(phi), one value for the body each.

    - `names`: quantities, (unknowns,); `first`: log(phi) where the scene or `initial` put them [1].
    - `bounds`: of log(phi), (unknowns, 2) [1].
    - `objective`: of the fit, its fields those of `first`; `mesh`: they live on.
    - `runs`: names of the runs, as the objective numbers them.
    """

    names: tuple[str, ...]
    first: Float[np.ndarray, " unknowns"]
    bounds: Float[np.ndarray, "unknowns 2"]
    objective: Objective
    mesh: Mesh
    runs: tuple[str, ...]

    def __call__(
        self, logs: Float[np.ndarray, " unknowns"]
    ) -> tuple[Float[np.ndarray, " values"], Float[np.ndarray, "values unknowns"]]:
        """Whitened residual, half whose square a fit makes small, and its slopes by log(phi) [1].

        Raises `InputError` where a value is not within the bounds of its quantity.
        """
        parameters = {}
        for name, log, (low, high) in zip(self.names, logs, self.bounds, strict=True):
            if not low <= log <= high:
                quantity = QUANTITIES[name]
                raise InputError(
                    "a value is not within its bounds", where=name, value=float(np.exp(log)),
                    limit=f"{quantity.lower:g} to {quantity.upper:g} {quantity.unit}",
                    remedy="keep the logarithms within `bounds`",
                )  # fmt: skip
            field, _ = Uniform().make(QUANTITIES[name], self.mesh, float(np.exp(log)), 0)
            parameters[name] = field.parameters()
        residual, matrix = program(jacobian)(self.objective, parameters)
        change = logarithm_slopes(self.objective, parameters, self.names, Uniform.__name__)
        return np.asarray(residual), np.asarray(matrix) @ np.linalg.inv(change)

    def defect(self) -> dict[str, Float[np.ndarray, "frames samples"]]:
        """What is taken off for cells and steps, by run [K]; zero where nothing is."""
        apart = [np.asarray(one) for case in self.objective.cases for one in case.defect]
        numbers = self.objective.sequence
        return {self.runs[number]: one for number, one in zip(numbers, apart, strict=True)}


def log_model(
    data: Scene | str | Path,
    *,
    runs: tuple[str, ...] | None = None,
    unknown: tuple[str, ...] | None = None,
    prior: Prior | None = None,
    stepping: Stepping | None = None,
    meshing: Meshing | None = None,
    initial: dict[str, float] | None = None,
    model_error: float = 0.01,
) -> LogModel:
    """What `invert` makes small with one value for each unknown, as a function of its logarithms.

    Arguments as for `invert`, `initial` by quantity [SI] and `model_error` [K] among them; mesh and
    steps are made for the first values and stay, and so does what is measured there of their errors
    (`meshing.corrected`): ask it near the optimum. For `thermo.identify.profile` and for samplers:
    nothing is fitted here.

    Raises `InputError` as `invert` does.
    """
    task = unfitted(
        data, runs, unknown, Uniform(), prior or Prior(), stepping, meshing, initial,
        model_error=model_error,
    )  # fmt: skip
    ready = prepare(task)
    objective = make_objective(task, ready, task.meshing.order)
    if task.meshing.corrected:
        objective = with_shared(less_defects(task, ready, objective))
    values = [float(objective.fields[name].control_values()[0]) for name in task.names]
    limits = [(QUANTITIES[name].lower, QUANTITIES[name].upper) for name in task.names]
    runs = tuple(run.name for run in task.runs)
    return LogModel(task.names, np.log(values), np.log(limits), objective, ready.mesh, runs)
