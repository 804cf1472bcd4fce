"""What every time integrator answers, and the implicit stage that all of them solve."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from thermo.physics._balance import Balance, Rise, equivalent, missing_heat, step_matrix
from thermo.physics._conjugate_gradient import ConjugateGradient
from thermo.physics._outlook import Memory, Outlook
from thermo.physics._step_matrix import StepMatrix
from thermo.physics._warm_solve import tangent_solve, warm_solve
from thermo.physics.effects._effect import Time

Step = tuple[Float[Array, " nodes"], Memory, Bool[Array, ""]]
"""Nodal temperatures [K] after a step, what the next one begins from, and whether it converged."""

Loop = Callable[[Callable[[Any, Any], Any], Any, Any], tuple[Any, Any]]
"""How the stages of a step are run one after the other, like `jax.lax.scan`."""


class AbstractIntegrator(eqx.Module):
    """A one-step method for M dT/dt = F(T, t)."""

    @abstractmethod
    def order(self) -> int:
        """Order of accuracy in the step [1]."""

    @abstractmethod
    def solves(self) -> int:
        """Linear solves in a step [1]."""

    @abstractmethod
    def weight(self, size: Time) -> Time:
        """Of the heat rates in the matrix of a step of `size` [s]; [s]."""

    @abstractmethod
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


def within(start: Time, size: Time, share: float) -> Time:
    """A time inside the step [s]: a switch at its end belongs to the next step."""
    return start + size * min(max(share, 1e-9), 1 - 1e-9)


@eqx.filter_custom_jvp
def _increment(
    stage: Any,
    about: Float[Array, " nodes"] | None,
    past: Memory,
    which: Int[Array | np.ndarray, ""],
    matrix: StepMatrix,
    solver: ConjugateGradient,
    outlook: Outlook,
) -> Any:
    del about
    return warm_solve(matrix, missing_heat(*stage), past, which, solver, outlook)


@_increment.def_jvp
def _(primals: Any, tangents: Any) -> Any:
    stage, about, past, which, matrix, solver, outlook = primals
    # Not by `_increment` itself, or the reverse pass would not find the solve that it may keep.
    value, past, fine = warm_solve(matrix, missing_heat(*stage), past, which, solver, outlook)
    change, turned, before, *_ = tangents
    lacking = jnp.zeros_like(value)
    if any(leaf is not None for leaf in jax.tree.leaves((change, turned))):
        # What the solved stage lacks when all but its rise changes is what the rise must meet.
        # Matrix and heat are differentiated in one, which takes half the products.
        held = jax.lax.stop_gradient(value)
        _, lacking = eqx.filter_jvp(
            lambda s, at: missing_heat(*s, rise=Rise(held, at)), (stage, about), (change, turned)
        )
    before = jax.tree.map(
        lambda a, b: jnp.zeros_like(a) if b is None else b, past, before, is_leaf=eqx.is_array
    )
    tangent, after, _ = tangent_solve(matrix, lacking, before, which, solver, outlook)
    return (value, past, fine), (tangent, after, None)


def solve_stage(
    balance: Balance,
    guess: Float[Array, " nodes"],
    base: Float[Array, " nodes"] | None,
    time: Time,
    weight: Time,
    about: Float[Array, " nodes"] | None,
    matrix: StepMatrix | None,
    solver: ConjugateGradient,
    past: Memory,
    solves: Int[Array | np.ndarray, " iterations"],
    outlook: Outlook,
    moved: Bool[Array | np.ndarray, ""] | None = None,
) -> tuple[Float[Array, " nodes"], Memory, Bool[Array, ""]]:
    """Solve M (G(Y) - base) = weight F(Y, t) for Y [K] by Newton's method from `guess`.

    Arguments:

    - `guess`: first iterate, (nodes,) [K].
    - `base`: equivalent temperature at the left, (nodes,) [K]; None means G(guess).
    - `time`: of the stage [s]; `weight`: [s].
    - `matrix`: M + weight J for the first iteration where it is at hand [J/K], and `about`: the
      temperatures that it was linearised at where these are not the guess, (nodes,) [K].
    - `past`: rates that each solve found in the steps before [K/s]; `solves`: which of these the
      Newton iterations are [1].
    - `moved`: where it is known, whether the guess is at another temperature than the base.

    Returns Y [K], the rates for the next step and whether every solve converged.
    """
    prescribed = balance.model.prescribed
    current = guess
    if prescribed is not None:
        base = equivalent(balance, guess) if base is None else base
        current, moved = prescribed.impose(guess, time), None
    converged = jnp.asarray(True)
    for count in range(len(solves)):
        if count > 0 and base is None:
            base = equivalent(balance, guess)
        if matrix is None or count > 0:
            about, matrix = None, step_matrix(balance, current, weight)
        stage = (balance, current, base, time, weight, moved if count == 0 else None)
        rise, past, fine = _increment(
            stage, about, past, solves[count, ...], matrix, solver, outlook
        )
        current = current + rise
        converged = converged & fine
    return current, past, converged
