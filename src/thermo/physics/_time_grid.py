"""The steps of a simulation, laid out before it runs.

Steps are planned once and then kept: the simulation is then a fixed program, smooth in its
parameters, which an adaptive step inside an inversion is not.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from thermo._compiled import program
from thermo.errors import InputError
from thermo.physics._balance import Balance, assemble
from thermo.physics._conjugate_gradient import ConjugateGradient
from thermo.physics._model import Model
from thermo.physics.integrators import Sdirk2, step_with_error

SAFETY, SHRINK, GROW = 0.9, 0.2, 3.0

EVEN = 1e-9
"""Difference of steps [1], relative to their length, that is rounding."""


@final
class TimeGrid(eqx.Module):
    """Steps from t = 0 and the frames that they land on.

    - `start`, `size`: of each step, (steps,) [s].
    - `frame_step`: for each frame the number of steps done by then, (frames,).
    - `frame_time`: (frames,) [s].
    - `even`: whether all steps are of one length, so that one matrix serves them.
    """

    start: Float[Array | np.ndarray, " steps"]
    size: Float[Array | np.ndarray, " steps"]
    frame_step: Int[Array | np.ndarray, " frames"]
    frame_time: Float[Array | np.ndarray, " frames"]
    even: bool = eqx.field(static=True, default=False)


def _grid(ends: Sequence[float], frames: Float[np.ndarray, " frames"]) -> TimeGrid:
    edges = np.concatenate([[0.0], np.asarray(ends, float)])
    size = np.diff(edges)
    return TimeGrid(
        start=edges[:-1],
        size=size,
        frame_step=np.searchsorted(edges, frames - 1e-9).astype(np.int32),
        frame_time=np.asarray(frames, float),
        even=bool(np.ptp(size) < EVEN * size.max()),
    )


def uniform_steps(
    frames: Float[np.ndarray, " frames"], size: float, switches: Sequence[float] = ()
) -> TimeGrid:
    """Steps of at most `size` [s] that end exactly at every frame and every switch [s].

    Arguments:

    - `frames`: (frames,) [s], increasing and not negative.
    - `switches`: times that no step may cross [s].
    """
    stops = np.unique(np.concatenate([[0.0], np.asarray(frames, float), _inside(switches, frames)]))
    ends: list[float] = []
    for low, high in zip(stops[:-1], stops[1:], strict=True):
        count = max(int(np.ceil((high - low) / size - 1e-9)), 1)
        ends.extend(np.linspace(low, high, count + 1)[1:])
    return _grid(ends, np.asarray(frames, float))


def every_step(grid: TimeGrid) -> TimeGrid:
    """The same steps, with a frame at the start and at the end of each [s]."""
    edges = np.append(np.asarray(grid.start), grid.start[-1] + grid.size[-1])
    return TimeGrid(grid.start, grid.size, np.arange(len(edges), dtype=np.int32), edges, grid.even)


def lengthened(grid: TimeGrid, steps: int, frames: int) -> TimeGrid:
    """The same steps, then some of no duration up to so many `steps` [1], which change nothing.

    The last frame [s] is repeated up to so many `frames` [1]. Grids of one length share a compiled
    program, and can be stacked.
    """
    more = steps - len(grid.start)
    again = frames - len(grid.frame_time)
    end = float(np.asarray(grid.start)[-1] + np.asarray(grid.size)[-1])
    return TimeGrid(
        start=np.append(np.asarray(grid.start), np.full(more, end)),
        size=np.append(np.asarray(grid.size), np.zeros(more)),
        frame_step=np.pad(np.asarray(grid.frame_step), (0, again), mode="edge"),
        frame_time=np.pad(np.asarray(grid.frame_time), (0, again), mode="edge"),
    )


def rounded_up(count: int) -> int:
    """The least number [1] not below `count` of a few in each octave, a quarter more at most."""
    coarse = 2 ** max(count.bit_length() - 3, 0)
    return -(-count // coarse) * coarse


def _inside(switches: Sequence[float], frames: Float[np.ndarray, " frames"]) -> np.ndarray:
    return np.array([t for t in switches if 0 < t < frames[-1]], float)


def _refuse_nothing(tolerance: float, largest: float) -> None:
    for name, value in (("tolerance", tolerance), ("largest", largest)):
        if not value > 0:
            raise InputError(
                "no step can be planned with this",
                where=f"plan_steps: {name}",
                value=value,
                limit="a positive number",
                remedy="give the error of a step in K and the longest step in s",
            )


@program
def _try_step(
    scheme: Sdirk2,
    balance: Balance,
    temperature: Float[Array, " nodes"],
    start: Float[Array, ""],
    size: Float[Array, ""],
    solver: ConjugateGradient,
) -> tuple[Float[Array, " nodes"], Float[Array, ""]]:
    new, error = step_with_error(scheme, balance, temperature, start, size, solver)
    return new, error.max()


def plan_steps(
    model: Model,
    initial: Float[Array, " nodes"],
    frames: Float[np.ndarray, " frames"],
    *,
    tolerance: float,
    largest: float,
    switches: Sequence[float] = (),
    scheme: Sdirk2 | None = None,
) -> TimeGrid:
    """Choose steps whose estimated error stays below `tolerance`, for a second-order scheme.

    A step ends at each switch and at each frame. Given the last frame only, steps follow their
    error alone; `every_step` and `between_steps` then give the frames in between.

    Arguments:

    - `initial`: (nodes,) [K]; `frames`: candidate frames (frames,) [s].
    - `tolerance`: largest error of one step anywhere on the body [K].
    - `largest`: longest step [s].
    - `switches`: times that no step may cross [s].

    Raises `InputError` where the tolerance or the longest step is not positive.
    """
    _refuse_nothing(tolerance, largest)
    scheme = Sdirk2(2 if model.follows_temperature() else 1) if scheme is None else scheme
    frames = np.asarray(frames, float)
    jumps = _inside(switches, frames)
    stops = np.unique(np.append(jumps, frames))
    solver = ConjugateGradient(rtol=1e-5)
    balance = program(assemble)(model)
    smallest = 1e-4 * min(largest, float(frames[-1]))
    # Weakly typed, as a filled array is, the first step would be compiled apart from the others;
    # times, as JAX makes them of Python's numbers, would be cast at each step.
    temperature = jnp.asarray(initial, float)
    time, size = 0.0, 10 * smallest
    ends: list[float] = []
    while time < frames[-1] - 1e-9:
        reach = time + min(size, largest)
        goal = float(min(reach, stops[np.searchsorted(stops, time + 1e-9)]))
        length = goal - time
        now, long = jnp.asarray(time, float), jnp.asarray(length, float)
        new, error = _try_step(scheme, balance, temperature, now, long, solver)
        ratio = float(error) / tolerance
        size = length * float(np.clip(SAFETY * max(ratio, 1e-9) ** (-1 / 3), SHRINK, GROW))
        if ratio > 1 and length > 2 * smallest:
            size = max(size, smallest)
            continue
        time, temperature = goal, new
        ends.append(goal)
        if np.isclose(jumps, goal, rtol=0, atol=1e-9).any():
            size = 10 * smallest
    return _grid(ends, frames)
