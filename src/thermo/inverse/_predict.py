"""Temperatures under given conditions, and how well they meet a recording."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import final

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from thermo.errors import InputError
from thermo.inverse._body import (
    Meshing,
    check_values,
    make_mesh,
    of_order,
    solve_heat_once,
    state,
    surface_of,
)
from thermo.inverse._conditions import conditions, make_model, switches
from thermo.inverse._estimate import Estimate, RecoveredField, load_estimate, weighted_quantile
from thermo.inverse._properties import Properties, Stated, check_unknowns
from thermo.inverse._selection import select_runs
from thermo.inverse._stepping import free_grid
from thermo.mesh import Mesh, face_areas
from thermo.observe import Run, Scene, bind, read_scene
from thermo.physics import (
    Discretisation,
    ReadOut,
    between_steps,
    discretise,
)

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
    """

    points: Float[np.ndarray, "samples 3"]
    time: Float[np.ndarray, " frames"]
    temperature: Float[np.ndarray, "frames samples"]
    measured: Float[np.ndarray, "frames samples"]
    scores: dict[str, Scores]
    mesh: Mesh
    nodal_time: Float[np.ndarray, " moments"]
    nodal: Float[np.ndarray, "moments nodes"]


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


def _properties(
    mesh: Mesh, stated: Stated, fields: dict[str, RecoveredField], *, median: bool
) -> Properties:
    areas = face_areas(mesh)

    def cells(name: str, value: float) -> np.ndarray:
        if name not in fields:
            return np.full(len(mesh.cells), value)
        if median:
            middle = weighted_quantile(fields[name].faces, areas, 0.5)
            return np.full(len(mesh.cells), middle)
        return fields[name].cells

    def faces(name: str, value: float) -> np.ndarray:
        if name not in fields:
            return np.full(len(mesh.faces), value)
        if median:
            return np.full(len(mesh.faces), weighted_quantile(fields[name].faces, areas, 0.5))
        return fields[name].faces

    capacity = cells("volumetric_heat_capacity", stated.capacity)
    conductivity = cells("conductivity", stated.conductivity)
    if "diffusivity" in fields:
        conductivity = cells("diffusivity", 0.0) * capacity
    convection = faces("convection", stated.convection)
    if "scaled_convection" in fields:
        convection = faces("scaled_convection", 0.0) * stated.capacity
    emissivity = faces("emissivity", stated.emissivity)
    if "scaled_emissivity" in fields:
        emissivity = faces("scaled_emissivity", 0.0) * stated.capacity
    values = (conductivity, capacity, convection, emissivity)
    return Properties(*(jnp.asarray(value) for value in values))


def _equal(one: Properties, other: Properties) -> bool:
    pairs = zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True)
    return all(bool(jnp.array_equal(a, b)) for a, b in pairs)


def _with_corners(readout: ReadOut, space: Discretisation, mesh: Mesh) -> ReadOut:
    """Read the corners of the linear mesh after the samples."""
    place = np.empty(len(mesh.nodes), np.int32)
    place[mesh.cells] = space.mesh.cells[:, :4]
    nodes, weights = np.asarray(readout.nodes), np.asarray(readout.weights)
    corners = np.repeat(place[:, None], nodes.shape[1], axis=1)
    first = np.zeros((len(place), nodes.shape[1]))
    first[:, 0] = 1.0
    return ReadOut(np.concatenate([nodes, corners]), np.concatenate([weights, first]))


def _forward(
    mesh: Mesh, order: int, run: Run, bodies: dict[str, Properties], tolerance: float, where: str
) -> Prediction:
    space = discretise(of_order(mesh, order))
    readout, _ = bind(run.recording, space.mesh, where=where)
    readout = _with_corners(readout, space, mesh)
    first = next(iter(bodies.values()))
    grid = free_grid(mesh, first, run, tolerance=tolerance)
    under = conditions(run, space)
    recording = run.recording
    measured = np.where(recording.valid, recording.temperature, np.nan)
    samples = len(recording.points)
    results: dict[str, np.ndarray] = {}
    for name, body in bodies.items():
        same = next((other for other in results if _equal(bodies[other], body)), None)
        if same is not None:
            results[name] = results[same]
            continue
        ends = solve_heat_once(make_model(space, body, under), under, grid, readout)
        results[name] = between_steps(
            np.asarray(grid.frame_time), ends, recording.time, switches(run)
        )
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


def predict(
    data: Scene | str | Path,
    estimate: Estimate | str | Path,
    *,
    runs: tuple[str, ...] | None = None,
    tolerance: float = 5e-3,
) -> dict[str, Prediction]:
    """Predict runs with recovered fields, without fitting anything to them.

    Arguments:

    - `data`: a scene, or the folder of one.
    - `estimate`: the result of `invert`, or the folder that `thermo invert` left.
    - `runs`: names; all that are held out by default.
    - `tolerance`: error of a time step [K].

    Returns a prediction for each run, with scores of the spatial field and of its median over the
    surface [K]. Raises `InputError` for unknown runs and for an estimate that cannot be read.

    Source: paper, section 5 (checklist G10 to G17).
    """
    scene = data if isinstance(data, Scene) else read_scene(Path(data))
    picked = select_runs(scene, runs, held_out=True)
    if isinstance(estimate, Estimate):
        parts = (estimate.mesh, estimate.order, estimate.stated, estimate.fields)
    else:
        folder = Path(estimate)
        if (folder / "checkpoint.npz").exists() and not (folder / "estimate.npz").exists():
            raise InputError(
                "this fit was interrupted",
                where=str(folder),
                value="checkpoint.npz and no estimate.npz",
                limit="the folder of a finished fit",
                remedy="give the same `thermo invert` command again: it goes on",
            )
        parts = load_estimate(folder / "estimate.npz")
    mesh, order, stated, fields = parts
    bodies = {
        "spatial": _properties(mesh, stated, fields, median=False),
        "median": _properties(mesh, stated, fields, median=True),
    }
    return {
        run.name: _forward(
            mesh, order, run, bodies, tolerance, f"{scene.folder}: runs.{run.name}.recording"
        )
        for run in picked
    }


def simulate(
    data: Scene | str | Path,
    run: str,
    *,
    values: dict[str, float] | None = None,
    meshing: Meshing | None = None,
    tolerance: float = 5e-3,
) -> Prediction:
    """Simulate a run of a scene with uniform values.

    Arguments:

    - `data`: a scene, or the folder of one; `run`: the name of its run.
    - `values`: by quantity, in place of what the scene states [SI].
    - `meshing`: of the body; `tolerance`: error of a time step [K].

    Raises `InputError` where a property has no value, and as `read_scene` does.
    """
    scene = data if isinstance(data, Scene) else read_scene(Path(data))
    (picked,) = select_runs(scene, (run,), held_out=False)
    values = {} if values is None else values
    check_values(values, where="values.")
    meshing = Meshing() if meshing is None else meshing
    if scene.material.conductivity is None and not {"conductivity", "diffusivity"} & set(values):
        raise InputError(
            "the conductivity has no value",
            where=f"{scene.folder}/scene.json: material.conductivity",
            value="null",
            limit="a positive number [W/m/K]",
            remedy="give material.conductivity=0.2, for example",
        )
    check_unknowns(tuple(values), scene)
    stated = state(scene, values, 1.0)
    mesh = make_mesh(scene, surface_of(scene), stated.of("diffusivity"), meshing)
    body = _properties(mesh, stated, {}, median=False)
    where = f"{scene.folder}: runs.{run}.recording"
    return _forward(mesh, meshing.order, picked, {"stated": body}, tolerance, where)
