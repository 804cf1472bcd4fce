"""A second-order, L-stable scheme of two implicit stages with one matrix."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from thermo.physics._balance import (
    Balance,
    equivalent,
    heat_rate,
    step_matrix,
    stored_heat,
)
from thermo.physics._conjugate_gradient import ConjugateGradient
from thermo.physics._outlook import Outlook, Past, without_past
from thermo.physics.effects._effect import Time
from thermo.physics.integrators._integrator import (
    AbstractIntegrator,
    Step,
    solve_stage,
    within,
)

GAMMA = 1 - 0.5**0.5


@final
class Sdirk2(AbstractIntegrator):
    """Singly diagonally implicit Runge-Kutta with gamma = 1 - 1/sqrt(2).

    M (Y1 - T) = gamma dt F(Y1), M (Y2 - T) = (1 - gamma) dt F(Y1) + gamma dt F(Y2), T' = Y2.
    Second order, L-stable, stiffly accurate; two solves a step with the same matrix. One Newton
    iteration a stage keeps the order with radiation; properties that change with temperature
    want two.

    - `iterations`: Newton iterations a stage [1].

    Source: Alexander, SIAM J. Numer. Anal. 14 (1977) 1006.
    """

    iterations: int = eqx.field(static=True, default=1)

    def order(self) -> int:
        """Order of accuracy [1]."""
        return 2

    def solves(self) -> int:
        """Two stages, each with its iterations [1]."""
        return 2 * self.iterations

    def weight(self, size: Time) -> Time:
        """Of the heat rates in the matrix of a step of `size` [s]; [s]."""
        return GAMMA * size

    def step(
        self,
        balance: Balance,
        temperature: Float[Array, " nodes"],
        start: Time,
        size: Time,
        solver: ConjugateGradient,
        past: Past,
        outlook: Outlook,
    ) -> Step:
        """One step of `size` [s] after `start` [s], from the rates of the steps before [K/s]."""
        end, _, past, fine = _stages(self, balance, temperature, start, size, solver, past, outlook)
        return end, past, fine


def _stages(
    scheme: Sdirk2,
    balance: Balance,
    temperature: Float[Array, " nodes"],
    start: Time,
    size: Time,
    solver: ConjugateGradient,
    past: Past,
    outlook: Outlook,
) -> tuple[Float[Array, " nodes"], Float[Array, " nodes"], Past, Bool[Array, ""]]:
    weight = scheme.weight(size)
    matrix = step_matrix(balance, temperature, weight)
    old = equivalent(balance, temperature)

    guess, base, about = temperature, None, None
    found, converged, rises = (), jnp.asarray(True), []
    value = temperature
    for number, share in enumerate((GAMMA, 1.0)):
        before = past[number * scheme.iterations : (number + 1) * scheme.iterations]
        value, rates, fine = solve_stage(
            balance, guess, base, within(start, size, share), weight, about, matrix, solver, before,
            outlook,
        )  # fmt: skip
        rises.append(equivalent(balance, value) - old)
        guess, about = temperature + (value - temperature) / GAMMA, temperature
        base = old + (1 - GAMMA) / GAMMA * rises[-1]
        found, converged = (*found, *rates), converged & fine
    return value, rises[0], found, converged


def step_with_error(
    scheme: Sdirk2,
    balance: Balance,
    temperature: Float[Array, " nodes"],
    start: Time,
    size: Time,
    solver: ConjugateGradient,
) -> tuple[Float[Array, " nodes"], Float[Array, " nodes"]]:
    """One step [K] and an estimate of its error at each node [K].

    The slopes at the start and at both stages make a quadrature of third order; its difference
    from the step, filtered by the step's own matrix so that stiff parts do not count, estimates
    the local error.

    Source: Hosea and Shampine, Appl. Numer. Math. 20 (1996) 21, section 4, for the filter.
    """
    before = without_past(scheme.solves(), len(temperature))
    last, rise, *_ = _stages(scheme, balance, temperature, start, size, solver, *before)
    middle = 1 / (6 * GAMMA * (1 - GAMMA))
    late = 0.5 - middle * GAMMA
    early = 1 - middle - late
    slope_first = stored_heat(balance, rise) / GAMMA
    total = equivalent(balance, last) - equivalent(balance, temperature)
    slope_last = stored_heat(balance, total - (1 - GAMMA) / GAMMA * rise) / GAMMA
    slope_start = size * heat_rate(balance, temperature, within(start, size, 0.0))
    defect = (
        early * slope_start + (middle - (1 - GAMMA)) * slope_first + (late - GAMMA) * slope_last
    )
    if balance.model.prescribed is not None:
        defect = defect * balance.model.prescribed.free()
    matrix = step_matrix(balance, temperature, GAMMA * size)
    error, *_ = solver.solve(matrix, defect, jnp.zeros_like(defect))
    return last, jnp.abs(error)
