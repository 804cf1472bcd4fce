"""What a fit makes small: whitened residuals, smoothness, priors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final, final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float, Int, PyTree

from thermo.fields import AbstractField
from thermo.inverse._addition import Addition, extend, read_as
from thermo.inverse._case import Case
from thermo.inverse._conditions import make_model
from thermo.inverse._properties import Stated, properties
from thermo.inverse._reading_errors import whiten, without
from thermo.physics import (
    AbstractAdjoint,
    ConjugateGradient,
    Discretisation,
    ForwardOnly,
    Model,
    solve_heat,
)
from thermo.physics.integrators import AbstractIntegrator

Parameters = dict[str, PyTree[Float[Array, "..."]]]
"""Parameters of fields, by quantity name [1]."""


PAIRS = 64
"""Pairs of controls are filled up to a multiple of this many [1]."""


def _filled_up(pairs: Int[Array | np.ndarray, "pairs 2"]) -> Int[Array, "filled 2"]:
    """Pairs of a control with itself after the others: they differ by nothing and cost nothing.

    Other seeds make a few more or fewer pairs, and each number would need programs of its own.
    """
    missing = -len(pairs) % PAIRS
    if not missing:  # As where a prior is made again while a program is traced.
        return jnp.asarray(pairs)
    # By NumPy: JAX would compile a program for each number.
    return jnp.asarray(np.pad(np.asarray(pairs), ((0, missing), (0, 0))))


@final
class FieldPrior(eqx.Module):
    """What is believed of a field before the data.

    - `pairs`: neighbouring controls, (pairs, 2), filled up; `step`: standard deviation between
      neighbours of the difference of log(phi), or of what else the field holds to be smooth [1].
    - `centre`: a value in the field's unit, and `spread` the standard deviation of log(phi) about
      it [1]; infinity means that nothing is believed.
    - `decay`: weight of the squared parameters [1].

    Source: paper, appendix B.7 (checklist E1, E2), on a logarithmic scale so that the weight does
    not depend on the unit.
    """

    pairs: Int[Array, "pairs 2"] = eqx.field(converter=_filled_up)
    step: Float[Array, ""]
    centre: Float[Array, ""]
    spread: Float[Array, ""]
    decay: Float[Array, ""]


def neighbour_differences(prior: FieldPrior, field: AbstractField) -> Float[Array, " pairs"]:
    """By how much neighbours differ in what the field holds to be smooth [1]."""
    values = field.smooth_values()
    return values[prior.pairs[:, 0]] - values[prior.pairs[:, 1]]


def belief_residual(prior: FieldPrior, field: AbstractField) -> Float[Array, " terms"]:
    """Dimensionless residuals [1] of a field's prior value and parameter size."""
    log = jnp.log(field.control_values())
    about = (jnp.mean(log, keepdims=True) - jnp.log(prior.centre)) / prior.spread
    flat, _ = ravel_pytree(field.parameters())
    return jnp.concatenate([about, jnp.sqrt(prior.decay) * flat])


def prior_residual(prior: FieldPrior, field: AbstractField) -> Float[Array, " terms"]:
    """Dimensionless residuals [1] of a field's smoothness, then of its other priors."""
    smooth = neighbour_differences(prior, field) / prior.step
    return jnp.concatenate([smooth, belief_residual(prior, field)])


SETTLED: Final = 1e-4
GAIN: Final = 0.05
"""What a step must promise for a fit to go on: a share of the loss, or log-likelihood [1]."""


def _number(value: float | Float[Array, ""]) -> Float[Array, ""]:
    return jnp.asarray(value, float)


@final
class Objective(eqx.Module):
    """The whitened residual of several runs over one set of fields.

    - `fields`, `priors`: by quantity name; `stated`: the rest of the body's properties [SI].
    - `cases`: runs, stacked in groups of one shape.
    - `tangents`: a cheaper objective of the same shape whose dense Jacobian stands in, or None.
    - `sequence`: the numbers of the runs in the order in which `cases` hold them.
    - `integrator`, `solver`: of the simulation; `lagged`: the paper's radiation.
    - `settled`: a fit ends where a step promises less than this share of the loss [1], or
      `gain`, in units of log-likelihood [1]; or, by least squares, one step on where a step changes
      no parameter by more than `near` [1].

    Source: paper, appendix B.7 (checklist D4, E1, E2, E5).
    """

    space: Discretisation
    stated: Stated
    fields: dict[str, AbstractField]
    priors: dict[str, FieldPrior]
    cases: tuple[Case, ...]
    integrator: AbstractIntegrator
    solver: ConjugateGradient
    lagged: bool = eqx.field(static=True, default=False)
    tangents: Objective | None = None
    sequence: tuple[int, ...] = eqx.field(static=True, default=())
    # Numbers and not part of the program: a stage that stops sooner is not compiled anew.
    settled: Float[Array, ""] = eqx.field(converter=_number, default=SETTLED)
    gain: Float[Array, ""] = eqx.field(converter=_number, default=GAIN)
    near: Float[Array, ""] = eqx.field(converter=_number, default=0.0)


def start(objective: Objective) -> Parameters:
    """Parameters [1] of the objective's fields as they stand."""
    return {name: field.parameters() for name, field in objective.fields.items()}


def with_fields(objective: Objective, parameters: Mapping[str, PyTree]) -> dict[str, AbstractField]:
    """The objective's fields with other parameters [1]."""
    return {
        name: field.with_parameters(parameters[name]) for name, field in objective.fields.items()
    }


def case_temperatures(
    objective: Objective,
    fields: dict[str, AbstractField],
    case: Case,
    adjoint: AbstractAdjoint | None = None,
    additions: tuple[Addition, ...] = (),
) -> Float[Array, "frames samples"]:
    """Simulated readings [K] of one run at its samples and frames, its defect added.

    A camera sees what the body is at, not what cells make of it: its errors come after the defect.
    """
    model = extend(case_model(objective, fields, case), case.under, additions)
    initial = case.under.start(len(objective.space.mesh.nodes))
    temperature = solve_heat(
        model,
        initial,
        case.grid,
        integrator=objective.integrator,
        readout=case.readout,
        solver=objective.solver,
        adjoint=adjoint,
    ).temperature
    body_at = temperature if case.between is None else case.between @ temperature
    read = read_as(body_at + case.defect, case.time, case.under, case.pinned, additions)
    return read if case.remainder is None else read + case.remainder


def case_model(objective: Objective, fields: dict[str, AbstractField], case: Case) -> Model:
    """The heat equation of a body with these fields [SI] under one run's conditions."""
    space = objective.space
    values = {name: (field.cell_values(), field.face_values()) for name, field in fields.items()}
    body = properties(objective.stated, values, len(space.mesh.cells), len(space.mesh.faces))
    return make_model(space, body, case.under, lagged=objective.lagged)


def data_residual(
    objective: Objective,
    parameters: Parameters,
    case: Case,
    adjoint: AbstractAdjoint | None = None,
) -> Float[Array, " values"]:
    """Whitened residual [1] of one run."""
    fields = with_fields(objective, parameters)
    found = case_temperatures(objective, fields, case, adjoint)
    white = whiten(case.errors, case.used, found - case.data)
    return case.trust * without(case.shared, white).ravel()


def penalty(objective: Objective, parameters: Parameters) -> Float[Array, " terms"]:
    """Whitened residual [1] of all priors."""
    fields = with_fields(objective, parameters)
    terms = [prior_residual(objective.priors[name], field) for name, field in fields.items()]
    return jnp.concatenate(terms)


def residual(objective: Objective, parameters: Parameters) -> Float[Array, " all"]:
    """Whitened residual [1] of all runs, then of all priors."""
    parts = []
    for case in objective.cases:
        # One compiled program runs over the group: runs differ in numbers only.
        each = jax.lax.map(lambda one: data_residual(objective, parameters, one), case)
        parts.append(each.ravel())
    return jnp.concatenate([*parts, penalty(objective, parameters)])


def run_parts(
    objective: Objective,
) -> Iterator[tuple[int, slice, Float[np.ndarray, "frames samples"]]]:
    """Of each run its number, its part of the residual, and the weights there [1/K].

    The weights are those of readings by themselves, zero where there is none.
    """
    begin, numbers = 0, iter(objective.sequence)
    for case in objective.cases:
        for weight in np.asarray(case.weight()):
            yield next(numbers), slice(begin, begin + weight.size), weight
            begin += weight.size


def jacobian(
    objective: Objective, parameters: Parameters
) -> tuple[Float[Array, " all"], Float[Array, "all unknowns"]]:
    """Residual [1] and its dense Jacobian [1]; all directions share one pass through each run."""
    flat, unravel = ravel_pytree(parameters)
    basis = jnp.eye(len(flat))

    def push(function):  # noqa: ANN001, ANN202
        value, tangents = jax.vmap(
            lambda way: jax.jvp(function, (flat,), (way,)), out_axes=(None, 1)
        )(basis)
        return value, tangents

    values, tangents = [], []
    for case in objective.cases:
        value, tangent = jax.lax.map(
            lambda one: push(
                lambda point: data_residual(objective, unravel(point), one, ForwardOnly())
            ),
            case,
        )
        values.append(value.ravel())
        tangents.append(tangent.reshape(-1, len(flat)))
    value, tangent = push(lambda point: penalty(objective, unravel(point)))
    return jnp.concatenate([*values, value]), jnp.concatenate([*tangents, tangent])
