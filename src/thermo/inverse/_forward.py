"""One run under given properties: temperatures, and how well they meet a recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.inverse._addition import Addition, extend, read_now
from thermo.inverse._body import of_order
from thermo.inverse._case import pinned
from thermo.inverse._conditions import conditions, make_model
from thermo.inverse._properties import Properties
from thermo.inverse._side_by_side import solve_each
from thermo.inverse._stepping import free_grid, longest_reach
from thermo.mesh import Mesh
from thermo.observe import Run, bind
from thermo.physics import Discretisation, ReadOut, TimeGrid, between_steps, discretise
from thermo.physics.integrators import Sdirk2

MOMENTS = 13
"""Frames of a run that are kept for the whole body [1]."""


@final
@dataclass(frozen=True)
class Scores:
    """Mean absolute, root mean square and largest difference from the recording [K]."""

    mae: float
    rmse: float
    max: float


@final
@dataclass(frozen=True)
class Prediction:
    """Simulated temperatures at a recording's samples and frames.

    - `points` (samples, 3) [m]; `time` (frames,) [s]; `temperature` (frames, samples) [K].
    - `measured` (frames, samples) [K], NaN where a value was not valid.
    - `scores`: of the spatial field, and of its median over the surface; [K].
    - `mesh`: linear mesh [m]; `nodal_time` (moments,) [s]; `nodal` (moments, nodes) [K]: the whole
      body at some of the frames.
    - `cells`: about what cells make wrong, root mean square over samples, (frames,) [K]; None where
      that was not measured.
    """

    points: Float[np.ndarray, "samples 3"]
    time: Float[np.ndarray, " frames"]
    temperature: Float[np.ndarray, "frames samples"]
    measured: Float[np.ndarray, "frames samples"]
    scores: dict[str, Scores]
    mesh: Mesh
    nodal_time: Float[np.ndarray, " moments"]
    nodal: Float[np.ndarray, "moments nodes"]
    cells: Float[np.ndarray, " frames"] | None = None


def score(
    simulated: Float[np.ndarray, "frames samples"], measured: Float[np.ndarray, "frames samples"]
) -> Scores:
    """Differences [K] over all valid readings; NaN readings are left out."""
    difference = np.abs(simulated - measured)
    return Scores(
        mae=float(np.nanmean(difference)),
        rmse=float(np.sqrt(np.nanmean(difference**2))),
        max=float(np.nanmax(difference)),
    )


def _equal(one: Properties, other: Properties) -> bool:
    pairs = zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True)
    return all(np.array_equal(np.asarray(a), np.asarray(b)) for a, b in pairs)


def _with_corners(readout: ReadOut, space: Discretisation, mesh: Mesh) -> ReadOut:
    """Read the corners of the linear mesh after the samples."""
    place = np.empty(len(mesh.nodes), np.int32)
    place[mesh.cells] = space.mesh.cells[:, :4]
    nodes, weights = np.asarray(readout.nodes), np.asarray(readout.weights)
    corners = np.repeat(place[:, None], nodes.shape[1], axis=1)
    first = np.zeros((len(place), nodes.shape[1]))
    first[:, 0] = 1.0
    return ReadOut(np.concatenate([nodes, corners]), np.concatenate([weights, first]))


def forward(
    mesh: Mesh,
    order: int,
    run: Run,
    bodies: dict[str, Properties],
    steps: TimeGrid,
    where: str,
    additions: tuple[Addition, ...] = (),
) -> Prediction:
    """Simulate a run with each of `bodies`; the first one's temperatures [K] are kept.

    Arguments:

    - `mesh`: linear mesh [m]; `order` of the cells to simulate with [1].
    - `bodies`: properties by name, on the linear mesh's cells and faces [SI].
    - `steps`: [s], a frame after each; `where`: the recording's name in messages.
    - `additions`: effects beside the stated ones.

    Raises `InputError` where samples lie away from the surface, and where what is stated leads to
    temperatures that there cannot be.
    """
    space = discretise(of_order(mesh, order), _reach(bodies, steps))
    readout, _ = bind(run.recording, space.mesh, where=where)
    wide = _with_corners(readout, space, mesh)
    results = _each(space, run, bodies, steps, wide, additions)
    _check_temperatures(results, run, where.removesuffix(".recording"))
    recording = run.recording
    measured = np.where(recording.valid, recording.temperature, np.nan)
    samples = len(recording.points)
    scores = {name: score(result[:, :samples], measured) for name, result in results.items()}
    first = next(iter(results.values()))
    frames = len(recording.time)
    moments = np.unique(np.linspace(0, frames - 1, min(MOMENTS, frames)).astype(int))
    return Prediction(
        points=recording.points,
        time=recording.time,
        temperature=first[:, :samples],
        measured=measured,
        scores=scores,
        mesh=mesh,
        nodal_time=recording.time[moments],
        nodal=first[moments, samples:],
    )


def _check_temperatures(
    results: dict[str, Float[np.ndarray, "frames samples"]], run: Run, where: str
) -> None:
    for found in results.values():
        low, high = np.min(found), np.max(found)
        if not (low > 0 and np.isfinite(high)):
            lamp = "" if run.heater is None else f", its lamp of {run.heater.power:g} W"
            raise InputError(
                "what is stated leads to temperatures that there cannot be", where=where,
                value=f"{low:.3g} to {high:.3g} K", limit="above 0 K",
                remedy=f"check the units of this run{lamp}, and of the material: they are SI",
            )  # fmt: skip


def temperatures(
    mesh: Mesh, order: int, run: Run, bodies: dict[str, Properties], tolerance: float, where: str
) -> dict[str, Float[np.ndarray, "frames samples"]]:
    """What each of `bodies` reads at a recording's samples and frames [K].

    Arguments as for `forward`; steps [s] are those that the first body asks for, `tolerance` the
    error of one [K].

    Raises `InputError` where samples lie away from the surface.
    """
    steps = free_grid(mesh, next(iter(bodies.values())), run, tolerance=tolerance)
    space = discretise(of_order(mesh, order), _reach(bodies, steps))
    readout, _ = bind(run.recording, space.mesh, where=where)
    return _each(space, run, bodies, steps, readout)


def _reach(bodies: dict[str, Properties], steps: TimeGrid) -> float:
    diffusivity = max(
        float(np.median(np.asarray(one.conductivity) / np.asarray(one.capacity)))
        for one in bodies.values()
    )
    return longest_reach(Sdirk2(), [steps], diffusivity)


def _each(
    space: Discretisation,
    run: Run,
    bodies: dict[str, Properties],
    grid: TimeGrid,
    readout: ReadOut,
    additions: tuple[Addition, ...] = (),
) -> dict[str, Float[np.ndarray, "frames read"]]:
    under = conditions(run, space)
    # Equal bodies are simulated once.
    like = {
        name: next(other for other in bodies if _equal(bodies[other], body))
        for name, body in bodies.items()
    }
    different = list(dict.fromkeys(like.values()))
    models = [
        extend(make_model(space, bodies[name], under), under, additions) for name in different
    ]
    ends, time = np.asarray(grid.frame_time), run.recording.time
    # The body's corners, where they are read after the samples, have no error of their own.
    known = pinned(run)
    held = jnp.asarray(np.pad(known, (0, len(readout.nodes) - len(known))))
    found = {}
    for name, values in zip(different, solve_each(models, under, grid, readout), strict=True):
        at = jnp.asarray(between_steps(ends, values, time, run.switches()))
        found[name] = np.asarray(read_now(at, jnp.asarray(time), under, held, additions))
    return {name: found[other] for name, other in like.items()}
