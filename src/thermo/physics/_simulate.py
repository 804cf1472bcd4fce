"""The forward simulation."""

from __future__ import annotations

from typing import Any, final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from thermo.physics._adjoint import AbstractAdjoint, StoreSteps
from thermo.physics._balance import assemble, with_weight
from thermo.physics._conjugate_gradient import SINGLE, ConjugateGradient
from thermo.physics._model import Model
from thermo.physics._outlook import Memory, Outlook, outlooks, without_past
from thermo.physics._readout import ReadOut, every_node
from thermo.physics._time_grid import TimeGrid
from thermo.physics.integrators import AbstractIntegrator

State = tuple[Float[Array, " nodes"], Memory]


@final
class Solution(eqx.Module):
    """What a simulation leaves.

    - `time`: (frames,) [s]; `temperature`: (frames, samples) [K].
    - `final`: nodal temperatures at the end, (nodes,) [K].
    - `converged`: whether every linear solve reached its tolerance.
    """

    time: Float[Array | np.ndarray, " frames"]
    temperature: Float[Array, "frames samples"]
    final: Float[Array, " nodes"]
    converged: Bool[Array, ""]


def solve_heat(
    model: Model,
    initial: Float[Array, " nodes"],
    grid: TimeGrid,
    *,
    integrator: AbstractIntegrator,
    readout: ReadOut | None = None,
    solver: ConjugateGradient | None = None,
    adjoint: AbstractAdjoint | None = None,
) -> Solution:
    """Integrate the heat equation over the steps of `grid`.

    Pure: works under `jax.jit`, `grad`, `jvp` and `vmap`. Batches of tangents are solved together.

    Arguments:

    - `model`: body and effects; `initial`: nodal temperatures, (nodes,) [K].
    - `grid`: the steps and the frames to keep [s].
    - `integrator`: the scheme; `readout`: where to read, every node by default.
    - `solver`: of the linear systems; its `rtol` [1] is relative to each step's own change in K.
    - `adjoint`: what the reverse pass keeps.

    Source: paper, section 4.2 (checklist B1 to B9).
    """
    solver = ConjugateGradient() if solver is None else solver
    readout = every_node(len(model.space.mesh.nodes)) if readout is None else readout
    adjoint = StoreSteps() if adjoint is None else adjoint
    # Not weakly typed, as a filled array is: the steps hand on what is not.
    initial = jnp.asarray(initial, initial.dtype)
    balance = assemble(model, single=solver.rtol >= SINGLE)

    def step(state: State, interval: tuple[Array, Array, Outlook]) -> tuple[State, Any]:
        old, past = state
        start, size, outlook = interval
        new, past, fine = integrator.step(
            balance, old, start, size, solver, past, outlook, adjoint.stages
        )
        return (new, past), (readout.read(new), fine)

    start, size = jnp.asarray(grid.start), jnp.asarray(grid.size)
    if grid.even:
        balance = with_weight(balance, integrator.weight(size[0]))
    past, _ = without_past(integrator.solves(), len(initial))
    steps = (start, size, outlooks(start, size))
    (final_state, _), (samples, fine) = adjoint.run(step, (initial, past), steps)
    history = jnp.concatenate([readout.read(initial)[None], samples])
    return Solution(
        time=grid.frame_time,
        temperature=history[grid.frame_step],
        final=final_state,
        converged=jnp.all(fine),
    )
