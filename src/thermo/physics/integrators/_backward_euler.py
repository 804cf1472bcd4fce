"""Backward Euler."""

from __future__ import annotations

from typing import final

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from thermo.physics._balance import Balance
from thermo.physics._conjugate_gradient import ConjugateGradient
from thermo.physics._outlook import Memory, Outlook
from thermo.physics.effects._effect import Time
from thermo.physics.integrators._integrator import (
    AbstractIntegrator,
    Loop,
    Step,
    solve_stage,
    within,
)


@final
class BackwardEuler(AbstractIntegrator):
    """M (T' - T) = dt F(T', t + dt), first order, L-stable, one solve a step and iteration.

    With `LaggedRadiation` and one iteration this is the paper's scheme.

    - `iterations`: Newton iterations [1]; one linearises about the old temperature.

    Source: paper, appendix B.4 (checklist B5).
    """

    iterations: int = eqx.field(static=True, default=1)

    def order(self) -> int:
        """Order of accuracy [1]."""
        return 1

    def solves(self) -> int:
        """One linear solve an iteration [1]."""
        return self.iterations

    def weight(self, size: Time) -> Time:
        """Of the heat rates in the matrix of a step of `size` [s]; [s]."""
        return size

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
        del loop
        end = within(start, size, 1.0)
        return solve_stage(
            balance, temperature, None, end, size, None, None, solver, past,
            np.arange(self.iterations), outlook,
        )  # fmt: skip
