"""What every time integrator answers, and the implicit stage that all of them solve."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import lineax as lx
from jaxtyping import Array, Float

from thermo.physics._balance import Balance, equivalent, heat_rate, step_matrix, stored_heat
from thermo.physics._conjugate_gradient import ConjugateGradient
from thermo.physics._sparse_operator import SparseOperator
from thermo.physics.effects._effect import Time

Past = Float[Array, "solves nodes"]
"""Rates [K/s] that the linear solves of a step found: where those of the next one begin."""

Step = tuple[Float[Array, " nodes"], Past, Any]
"""Nodal temperatures [K] after a step, what the next one begins from, and the result."""


class AbstractIntegrator(eqx.Module):
    """A one-step method for M dT/dt = F(T, t)."""

    @abstractmethod
    def order(self) -> int:
        """Order of accuracy in the step [1]."""

    @abstractmethod
    def solves(self) -> int:
        """Linear solves in a step [1]."""

    @abstractmethod
    def step(
        self,
        balance: Balance,
        temperature: Float[Array, " nodes"],
        start: Time,
        size: Time,
        solver: ConjugateGradient,
        past: Past,
    ) -> Step:
        """One step of `size` [s] after `start` [s], from the rates of the step before [K/s]."""


def within(start: Time, size: Time, share: float) -> Time:
    """A time inside the step [s]: a switch at its end belongs to the next step."""
    return start + size * min(max(share, 1e-9), 1 - 1e-9)


@eqx.filter_custom_jvp
def _solve_from(
    matrix: SparseOperator, heat: Float[Array, " nodes"], guess: Any, solver: ConjugateGradient
) -> tuple[Float[Array, " nodes"], Any]:
    solution = lx.linear_solve(matrix, heat, solver, options={"y0": guess}, throw=False)
    return solution.value, solution.result


@_solve_from.def_jvp
def _(primals: Any, tangents: Any) -> Any:
    # The derivative of a solution does not know where its iterations began, and solves for
    # tangents begin from nothing: their tolerance is relative to themselves.
    matrix, heat, guess, solver = primals
    value, result = _solve_from(matrix, heat, guess, solver)
    change, more, *_ = tangents
    if any(leaf is not None for leaf in jax.tree.leaves(change)):
        _, product = eqx.filter_jvp(lambda a: a.mv(value), (matrix,), (change,))
        more = -product if more is None else more - product
    if more is None:
        more = jnp.zeros_like(heat)
    tangent = lx.linear_solve(matrix, more, solver, throw=False).value
    return (value, result), (tangent, jax.tree.map(lambda _: None, result))


def solve_increment(
    matrix: SparseOperator,
    heat: Float[Array, " nodes"],
    solver: ConjugateGradient,
    guess: Float[Array, " nodes"],
) -> tuple[Float[Array, " nodes"], Any]:
    """Increment [K] that takes up the given heat [J], from a guess of it [K]; and the result."""
    return _solve_from(matrix, heat, jax.lax.stop_gradient(guess), solver)


def rates(increments: Float[Array, "solves nodes"], size: Time) -> Past:
    """Increments [K] of a step of `size` [s] as rates [K/s]; steps of no duration have none."""
    size = jnp.asarray(size)
    return jax.lax.stop_gradient(
        jnp.where(size > 0, increments / jnp.where(size > 0, size, 1.0), 0.0)
    )


def solve_stage(
    balance: Balance,
    guess: Float[Array, " nodes"],
    base: Float[Array, " nodes"] | None,
    time: Time,
    weight: Time,
    matrix: SparseOperator | None,
    solver: ConjugateGradient,
    begin: Float[Array, "iterations nodes"],
) -> tuple[Float[Array, " nodes"], Float[Array, "iterations nodes"], Any]:
    """Solve M (G(Y) - base) = weight F(Y, t) for Y [K] by Newton's method from `guess`.

    Arguments:

    - `guess`: first iterate, (nodes,) [K].
    - `base`: equivalent temperature at the left, (nodes,) [K]; None means G(guess).
    - `time`: of the stage [s]; `weight`: [s].
    - `matrix`: M + weight J for the first iteration where it is at hand [J/K].
    - `begin`: guess of the increment of each Newton iteration [K].

    Returns Y [K], the increments [K] and the result.
    """
    prescribed = balance.model.prescribed
    current = guess
    if prescribed is not None:
        base = equivalent(balance, guess) if base is None else base
        current = prescribed.impose(guess, time)
    result = lx.RESULTS.successful
    increments = []
    for count in range(len(begin)):
        heat = weight * heat_rate(balance, current, time)
        if count > 0 and base is None:
            base = equivalent(balance, guess)
        if base is not None:
            heat = heat - stored_heat(balance, equivalent(balance, current) - base)
        if prescribed is not None:
            heat = heat * prescribed.free()
        if matrix is None or count > 0:
            matrix = step_matrix(balance, current, weight)
        increment, outcome = solve_increment(matrix, heat, solver, begin[count])
        increments.append(increment)
        current = current + increment
        result = lx.RESULTS.where(outcome == lx.RESULTS.successful, result, outcome)
    return current, jnp.stack(increments), result
