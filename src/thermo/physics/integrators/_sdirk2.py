"""A second-order, L-stable scheme of two implicit stages with one matrix."""

from __future__ import annotations

from typing import Any, final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from thermo.physics._balance import (
    Balance,
    equivalent,
    heat_rate,
    step_matrix,
    stored_heat,
)
from thermo.physics._conjugate_gradient import ConjugateGradient
from thermo.physics._outlook import Memory, Outlook, without_past
from thermo.physics.effects._effect import Time
from thermo.physics.integrators._integrator import (
    AbstractIntegrator,
    Loop,
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
        past: Memory,
        outlook: Outlook,
        loop: Loop,
    ) -> Step:
        """One step of `size` [s] after `start` [s], from the rates of the steps before [K/s]."""
        end, _, past, fine = _stages(
            self, balance, temperature, start, size, solver, past, outlook, loop
        )
        return end, past, fine


def _stages(
    scheme: Sdirk2,
    balance: Balance,
    temperature: Float[Array, " nodes"],
    start: Time,
    size: Time,
    solver: ConjugateGradient,
    past: Memory,
    outlook: Outlook,
    loop: Loop,
) -> tuple[Float[Array, " nodes"], Float[Array, " nodes"], Memory, Bool[Array, ""]]:
    weight = scheme.weight(size)
    matrix = step_matrix(balance, temperature, weight)
    old = equivalent(balance, temperature)

    # A loop, so that a stage is compiled once: the first follows on a rise of nothing.
    def stage(carry: Any, each: Any) -> Any:
        before, past = carry
        time, solves, moved = each
        guess = temperature + (before - temperature) / GAMMA
        base = old + (1 - GAMMA) / GAMMA * (equivalent(balance, before) - old)
        value, past, fine = solve_stage(
            balance, guess, base, time, weight, temperature, matrix, solver, past, solves, outlook,
            moved,
        )  # fmt: skip
        return (value, past), (before, fine)

    times = jnp.stack([within(start, size, share) for share in (GAMMA, 1.0)])
    solves = np.arange(scheme.solves()).reshape(2, -1)
    (value, past), (begun, fine) = loop(
        stage, (temperature, past), (times, solves, solves[:, 0] > 0)
    )
    return value, equivalent(balance, begun[1]) - old, past, jnp.all(fine)


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
    last, rise, *_ = _stages(
        scheme, balance, temperature, start, size, solver, *before, jax.lax.scan
    )
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
