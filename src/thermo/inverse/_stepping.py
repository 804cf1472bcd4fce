"""How time is cut into steps: for a fit, for its tangents, for a prediction."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from thermo.inverse._conditions import conditions, make_model
from thermo.inverse._properties import Properties, Stated, properties
from thermo.mesh import Mesh
from thermo.observe import Run
from thermo.physics import TimeGrid, discretise, every_step, plan_steps, uniform_steps
from thermo.physics.integrators import AbstractIntegrator, BackwardEuler, Sdirk2

COARSER = 10.0
"""Tolerance of the steps that tangents take, over that of the fit [1]; half as many steps."""

LEAST_STEPS = 40.0
"""Steps of a run [1], however slowly it changes: what is read between them is interpolated."""


@final
@dataclass(frozen=True)
class Stepping:
    """How time is cut into steps.

    - `integrator`: the scheme. A first-order one takes steps of `size` [s]; a second-order one
      plans its steps for `tolerance` [K] an error a step.
    - `most_frames`: the most frames of a run that are fitted, evenly spread [1]; steps of given
      size fit them all.
    - `rtol`: of the linear solver, relative to each step's own change [1].
    - `lagged`: the paper's lagged radiation.
    """

    integrator: AbstractIntegrator = field(default_factory=Sdirk2)
    size: float = 0.1
    tolerance: float = 5e-3
    most_frames: int = 120
    rtol: float = 1e-4
    lagged: bool = False


def scheme_for(integrator: AbstractIntegrator, stated: Stated) -> AbstractIntegrator:
    """The scheme, with two iterations a stage where what is stated follows the temperature."""
    follows = stated.conductivity_law is not None or stated.capacity_law is not None
    if follows and isinstance(integrator, BackwardEuler | Sdirk2) and integrator.iterations == 1:
        return replace(integrator, iterations=2)
    return integrator


def fit_frames(run: Run, stepping: Stepping) -> TimeGrid:
    """The frames [s] of a run that are fitted: evenly spread, at most `most_frames`.

    For a scheme of given steps also the steps, which end on them.
    """
    time = run.recording.time
    if isinstance(stepping.integrator, BackwardEuler):
        return uniform_steps(time, stepping.size, run.switches())
    count = min(stepping.most_frames, len(time))
    picked = np.unique(np.linspace(0, len(time) - 1, count).round().astype(int))
    return uniform_steps(time[picked], float(time[-1]))


def longest_reach(
    scheme: AbstractIntegrator, grids: Iterable[TimeGrid], diffusivity: float
) -> float:
    """The square of how far heat goes in the longest step [m2], from a diffusivity [m2/s]."""
    longest = max(float(np.max(grid.size)) for grid in grids)
    return diffusivity * float(scheme.weight(longest))


def free_grid(
    mesh: Mesh, body: Properties, run: Run, *, tolerance: float, least_steps: float = LEAST_STEPS
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
        switches=run.switches(),
    )
    return every_step(grid)


def planned_steps(
    mesh: Mesh, stated: Stated, run: Run, stepping: Stepping, *, coarser: float = 1.0
) -> TimeGrid | None:
    """Steps [s] planned on the linear mesh, or None for a scheme of given steps.

    `coarser`: over the tolerance, and the longest step over the usual one, [1].
    """
    if isinstance(stepping.integrator, BackwardEuler):
        return None
    body = properties(stated, {}, len(mesh.cells), len(mesh.faces))
    return free_grid(
        mesh,
        body,
        run,
        tolerance=coarser * stepping.tolerance,
        least_steps=LEAST_STEPS / coarser ** (1 / 3),
    )
