"""Independent runs of one body, as many at a time as there are cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np
from jaxtyping import Array, Float

from thermo._compiled import program
from thermo.inverse._conditions import Conditions
from thermo.physics import (
    ConjugateGradient,
    ForwardOnly,
    Model,
    ReadOut,
    TimeGrid,
    lengthened,
    rounded_up,
    solve_heat,
)
from thermo.physics.integrators import Sdirk2

One = TypeVar("One")
Made = TypeVar("Made")


def at_once(work: Callable[[One], Made], items: Iterable[One]) -> list[Made]:
    """What `work` makes of each item, in their order, in a thread a core.

    A program by itself keeps little more than one core busy, and so does compiling it.
    """
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(work, items))


def solve_each(
    models: Iterable[Model], under: Conditions, grid: TimeGrid, readout: ReadOut
) -> list[Float[np.ndarray, "frames samples"]]:
    """Temperatures [K] at the samples for each model, in their order; compiled once for all.

    Runs whose numbers of steps are alike share a program too: compiling takes longer than a run.

    Arguments:

    - `models`: of one mesh, with the same kinds of effects; `under`: where their start is from.
    - `grid`: steps and frames [s]; `readout`: of the samples.
    """
    frames, steps = len(grid.frame_time), len(grid.start)
    # Steps of one length have a program of their own, with one matrix, and stay as they are.
    wide = grid if grid.even else lengthened(grid, rounded_up(steps), rounded_up(frames - 1) + 1)

    def solve(model: Model) -> Float[np.ndarray, "frames samples"]:
        return np.asarray(_solve(model, under, wide, readout))[:frames]

    return at_once(solve, models)


@program
def _solve(
    model: Model, under: Conditions, grid: TimeGrid, readout: ReadOut
) -> Float[Array, "frames samples"]:
    return solve_heat(
        model,
        under.start(len(model.space.mesh.nodes)),
        grid,
        integrator=Sdirk2(iterations=2 if model.follows_temperature() else 1),
        readout=readout,
        solver=ConjugateGradient(rtol=1e-5),
        adjoint=ForwardOnly(),
    ).temperature
