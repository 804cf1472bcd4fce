"""How time is cut into steps: for a fit, for its tangents, for a prediction."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from thermo.inverse._conditions import conditions, make_model, switches
from thermo.inverse._properties import Properties, Stated, properties
from thermo.mesh import Mesh
from thermo.observe import Run
from thermo.physics import TimeGrid, discretise, every_step, plan_steps, uniform_steps
from thermo.physics.integrators import AbstractIntegrator, BackwardEuler, Sdirk2

COARSER = 10.0
"""Tolerance of the steps that tangents take, over that of the fit [1]; half as many steps."""


@final
@dataclass(frozen=True)
class Stepping:
    """How time is cut into steps.

    - `integrator`: the scheme. A first-order one takes steps of `size` [s]; a second-order one
      plans its steps for `tolerance` [K] an error a step.
    - `most_frames`: about the most frames of a run that are fitted [1].
    - `rtol`: of the linear solver, relative to each step's own change [1].
    - `lagged`: the paper's lagged radiation.
    """

    integrator: AbstractIntegrator = field(default_factory=Sdirk2)
    size: float = 0.1
    tolerance: float = 5e-3
    most_frames: int = 120
    rtol: float = 1e-4
    lagged: bool = False


def fit_grid(mesh: Mesh, stated: Stated, run: Run, stepping: Stepping) -> TimeGrid:
    """Steps [s] of a run's simulation, planned on the linear mesh, and the frames that they fit."""
    frames = run.recording.time
    if isinstance(stepping.integrator, BackwardEuler):
        return uniform_steps(frames, stepping.size, switches(run))
    space = discretise(mesh)
    body = properties(stated, {}, len(mesh.cells), len(mesh.faces))
    under = conditions(run, space)
    return plan_steps(
        make_model(space, body, under),
        under.start(len(space.mesh.nodes)),
        frames,
        tolerance=stepping.tolerance,
        largest=float(frames[-1]) / stepping.most_frames * 2,
        switches=switches(run),
        every_frame=False,
    )


def free_grid(
    mesh: Mesh, body: Properties, run: Run, *, tolerance: float, least_steps: float
) -> TimeGrid:
    """Steps [s] that heed switches only, a frame after each: frames are interpolated.

    `tolerance`: error of a step [K]; `least_steps`: in a run, however slowly it changes [1].
    """
    space = discretise(mesh)
    under = conditions(run, space)
    end = run.recording.time[-1:]
    grid = plan_steps(
        make_model(space, body, under),
        under.start(len(space.mesh.nodes)),
        end,
        tolerance=tolerance,
        largest=float(end[0]) / least_steps,
        switches=switches(run),
    )
    return every_step(grid)


def tangent_grid(mesh: Mesh, stated: Stated, run: Run, stepping: Stepping) -> TimeGrid | None:
    """Fewer steps [s] for derivatives, or None for a scheme whose steps are given."""
    if isinstance(stepping.integrator, BackwardEuler):
        return None
    body = properties(stated, {}, len(mesh.cells), len(mesh.faces))
    tolerance = COARSER * stepping.tolerance
    return free_grid(mesh, body, run, tolerance=tolerance, least_steps=stepping.most_frames / 8)
