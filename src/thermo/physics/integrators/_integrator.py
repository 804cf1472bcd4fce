"""What every time integrator answers, and the implicit stage that all of them solve."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import equinox as eqx
import lineax as lx
from jaxtyping import Array, Float

from thermo.physics._balance import Balance, equivalent, heat_rate, step_matrix, stored_heat
from thermo.physics._conjugate_gradient import ConjugateGradient
from thermo.physics._sparse_operator import SparseOperator
from thermo.physics.effects._effect import Time

Step = tuple[Float[Array, " nodes"], Any]


class AbstractIntegrator(eqx.Module):
    """A one-step method for M dT/dt = F(T, t)."""

    @abstractmethod
    def order(self) -> int:
        """Order of accuracy in the step [1]."""

    @abstractmethod
    def step(
        self,
        balance: Balance,
        temperature: Float[Array, " nodes"],
        start: Time,
        size: Time,
        solver: ConjugateGradient,
    ) -> Step:
        """Nodal temperatures [K] one step of `size` [s] after `start` [s], and the result."""


def within(start: Time, size: Time, share: float) -> Time:
    """A time inside the step [s]: a switch at its end belongs to the next step."""
    return start + size * min(max(share, 1e-9), 1 - 1e-9)


def solve_increment(
    matrix: SparseOperator, heat: Float[Array, " nodes"], solver: ConjugateGradient
) -> Step:
    """Increment [K] that takes up the given heat [J]."""
    solution = lx.linear_solve(matrix, heat, solver, throw=False)
    return solution.value, solution.result


def solve_stage(
    balance: Balance,
    guess: Float[Array, " nodes"],
    base: Float[Array, " nodes"] | None,
    time: Time,
    weight: Time,
    matrix: SparseOperator | None,
    iterations: int,
    solver: ConjugateGradient,
) -> tuple[Float[Array, " nodes"], Any]:
    """Solve M (G(Y) - base) = weight F(Y, t) for Y [K] by Newton's method from `guess`.

    Arguments:

    - `guess`: first iterate, (nodes,) [K].
    - `base`: equivalent temperature at the left, (nodes,) [K]; None means G(guess).
    - `time`: of the stage [s]; `weight`: [s].
    - `matrix`: M + weight J for the first iteration where it is at hand [J/K].
    - `iterations`: Newton iterations [1].
    """
    prescribed = balance.model.prescribed
    current = guess
    if prescribed is not None:
        base = equivalent(balance, guess) if base is None else base
        current = prescribed.impose(guess, time)
    result = lx.RESULTS.successful
    for count in range(iterations):
        heat = weight * heat_rate(balance, current, time)
        if count > 0 and base is None:
            base = equivalent(balance, guess)
        if base is not None:
            heat = heat - stored_heat(balance, equivalent(balance, current) - base)
        if prescribed is not None:
            heat = heat * prescribed.free()
        if matrix is None or count > 0:
            matrix = step_matrix(balance, current, weight)
        increment, outcome = solve_increment(matrix, heat, solver)
        current = current + increment
        result = lx.RESULTS.where(outcome == lx.RESULTS.successful, result, outcome)
    return current, result
