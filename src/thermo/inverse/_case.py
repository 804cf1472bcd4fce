"""A run made ready for a fit: conditions, steps, read-out, data and weights; several stacked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.inverse._conditions import Conditions, conditions, switches
from thermo.observe import Run, bind, estimate_noise
from thermo.physics import Discretisation, ReadOut, TimeGrid, between_steps


@final
class Case(eqx.Module):
    """One run, or several of the same shape stacked along a leading axis.

    - `grid`: steps and frames [s]; `readout`: where the samples are.
    - `data`: (frames, samples) [K]; `weight`: 1 / standard deviation, zero where there is no
      valid value, (frames, samples) [1/K].
    - `defect`: what is added to the simulation for its cells and steps, (frames, samples) [K].
    - `between`: where frames lie between the steps, the weights of what the grid's own frames
      read, (frames, ends) [1]; None where the grid's frames are those of the data.
    """

    under: Conditions
    grid: TimeGrid
    readout: ReadOut
    data: Float[Array, "*runs frames samples"]
    weight: Float[Array, "*runs frames samples"]
    defect: Float[Array, "*runs frames samples"]
    between: Float[Array, "*runs frames ends"] | None = None


def _offset(run: Run) -> np.ndarray | float:
    """Constant error [K] of each sample, from its quiet frames, where there are enough of them."""
    quiet = run.recording.quiet
    if quiet is None or len(quiet) < 3:
        return 0.0
    known = np.isfinite(quiet)
    error = np.where(known, quiet - run.initial_temperature, 0.0).sum(0)
    # A sample that is never seen quiet keeps its values.
    return error / np.maximum(known.sum(0), 1)


def make_case(
    run: Run,
    space: Discretisation,
    grid: TimeGrid,
    *,
    steps: TimeGrid | None = None,
    model_error: float,
    where: str,
) -> Case:
    """Bind a run to a mesh and weigh its data.

    The standard deviation of a reading is sqrt(white^2 (1 + r) / (1 - r) + model_error^2) with
    the white level and the frame-to-frame correlation r of the recording's noise. Each sample's
    constant error, known from its quiet frames, is taken off.

    Arguments:

    - `grid`: its frames must be frames of the recording [s].
    - `steps`: other steps to simulate by [s]; frames of `grid` are interpolated between them.
    - `model_error`: what the simulation itself may be wrong by [K].

    Raises `InputError` where samples lie away from the surface.
    """
    recording = run.recording
    readout, _ = bind(recording, space.mesh, where=where)
    frames = np.searchsorted(recording.time, np.asarray(grid.frame_time) - 1e-9)
    noise = estimate_noise(recording)
    r = min(max(noise.correlation, 0.0), 0.95)
    deviation = float(np.hypot(noise.white * np.sqrt((1 + r) / (1 - r)), model_error))
    data = recording.temperature[frames] - _offset(run)
    weight = np.where(recording.valid[frames], 1 / deviation, 0.0)
    read = (jnp.asarray(data), jnp.asarray(weight), jnp.zeros(data.shape))
    under = conditions(run, space)
    if steps is None:
        return Case(under, grid, readout, *read)
    ends = np.asarray(steps.frame_time)
    wanted = np.asarray(grid.frame_time)
    between = jnp.asarray(between_steps(ends, np.eye(len(ends)), wanted, switches(run)))
    return Case(under, steps, readout, *read, between)


def _pad(array: np.ndarray | Array, length: int, axis: int, *, edge: bool) -> np.ndarray:
    array = np.asarray(array)
    width = [(0, 0)] * array.ndim
    width[axis] = (0, length - array.shape[axis])
    return np.pad(array, width, mode="edge" if edge else "constant")


def _pad_case(case: Case, steps: int, ends: int, frames: int, samples: int) -> Case:
    """Lengthen a case by steps of no duration and by data of no weight."""
    end = float(np.asarray(case.grid.start)[-1] + np.asarray(case.grid.size)[-1])
    start = np.append(np.asarray(case.grid.start), np.full(steps - len(case.grid.start), end))
    grid = TimeGrid(
        start=start,
        size=_pad(case.grid.size, steps, 0, edge=False),
        frame_step=_pad(case.grid.frame_step, ends, 0, edge=True),
        frame_time=_pad(case.grid.frame_time, ends, 0, edge=True),
    )
    readout = ReadOut(
        _pad(case.readout.nodes, samples, 0, edge=True),
        _pad(case.readout.weights, samples, 0, edge=True),
    )
    data = _pad(_pad(case.data, frames, 0, edge=True), samples, 1, edge=True)
    weight, defect = (
        jnp.asarray(_pad(_pad(values, frames, 0, edge=False), samples, 1, edge=False))
        for values in (case.weight, case.defect)
    )
    between = case.between
    if between is not None:
        between = jnp.asarray(_pad(_pad(between, frames, 0, edge=False), ends, 1, edge=False))
    return Case(case.under, grid, readout, jnp.asarray(data), weight, defect, between)


def group_cases(cases: Sequence[Case]) -> list[list[int]]:
    """Numbers [1] of the runs that have the same effects, group by group."""
    groups: dict[str, list[int]] = {}
    for number, case in enumerate(cases):
        shape = str(jax.tree.structure(case.under)) + str(
            [np.shape(leaf) for leaf in jax.tree.leaves(case.under)]
        )
        groups.setdefault(shape, []).append(number)
    return list(groups.values())


def stack_cases(cases: Sequence[Case]) -> tuple[Case, ...]:
    """Stack the runs of each group, so that one program serves all of them [1]."""
    stacked = []
    for numbers in group_cases(cases):
        group = [cases[number] for number in numbers]
        steps = max(len(case.grid.start) for case in group)
        frames, samples = (max(case.data.shape[axis] for case in group) for axis in (0, 1))
        ends = max(len(case.grid.frame_step) for case in group)
        padded = [_pad_case(case, steps, ends, frames, samples) for case in group]
        stacked.append(
            jax.tree.map(lambda *leaves: jnp.stack([jnp.asarray(a) for a in leaves]), *padded)
        )
    return tuple(stacked)
