"""Independent runs of one body, as many at a time as there are cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Final, TypeVar

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

FEW_NODES: Final = 20000
"""Nodes [1] below which compiling a run takes longer than running it."""

One = TypeVar("One")
Made = TypeVar("Made")


def at_once(work: Callable[[One], Made], items: Iterable[One]) -> list[Made]:
    """What `work` makes of each item, in their order, in a thread a core.

    A program by itself keeps little more than one core busy, and so does compiling it.
    """
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(work, items))


def solve_each(
    models: Sequence[Model], under: Conditions, grid: TimeGrid, readout: ReadOut
) -> list[Float[np.ndarray, "frames samples"]]:
    """Temperatures [K] at the samples for each model, in their order; compiled once for all.

    Runs whose numbers of steps are alike share a program too: compiling takes longer than a run.

    Arguments:

    - `models`: of one mesh, with the same kinds of effects; `under`: where their start is from.
    - `grid`: steps and frames [s]; `readout`: of the samples.
    """
    frames, steps = len(grid.frame_time), len(grid.start)
    nodes = len(models[0].space.mesh.nodes)
    # Steps of one length have a program of their own, with one matrix, and stay as they are.
    more = (_shared(steps, nodes), _shared(frames - 1, nodes) + 1)
    wide = grid if grid.even else lengthened(grid, *more)

    def solve(model: Model) -> Float[np.ndarray, "frames samples"]:
        return np.asarray(_solve(model, under, wide, readout))[:frames]

    return at_once(solve, models)


def _shared(count: int, nodes: int) -> int:
    """Steps or frames [1] of runs that share a program: the next power of two on few nodes.

    With as many steps of no duration as others a run takes up to a sixth longer there (by hand).
    """
    return 1 << (count - 1).bit_length() if nodes < FEW_NODES else rounded_up(count)


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
