"""The case on the bench: coarse cells for slopes, fine ones to be measured against."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, final

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.discover._candidate import (
    AbstractHeatCandidate,
    AbstractReadingCandidate,
    Candidate,
)
from thermo.discover._extended import Extended, readings
from thermo.discover._memory import Memory
from thermo.errors import InputError
from thermo.inverse import (
    FINER,
    Objective,
    Ready,
    Task,
    at_once,
    coarse_tangents,
    finer_readings,
    finer_temperatures,
    lay_out,
    make_objective,
    mesh_for,
    stand_in,
    start,
    with_defects,
    with_remainders,
)
from thermo.mesh import Fine, Mesh
from thermo.physics.integrators import Sdirk2

# Edges of a fit's cells over those of cells that resolve an effect's place [1].
_SMALLER: Final = 1.6

# The same where a place has an edge, and how many nodes more that may take, over those of the fit.
_AT_EDGES: Final = 2.5
_MORE: Final = 4.0

FINEST: Final = 3.0
"""Edges of a fit's cells over those that a slight alarm is checked against [1]."""

FINEST_LEFT: Final = 1 / ((FINEST / FINER) ** 2 - 1)
"""What those cells are still wrong by, over how far they are from those half as long as a fit's
[1], where errors are of second order."""

Points = Float[np.ndarray, "points 3"]

Apart = list[Float[Array, "runs frames samples"]]
"""Temperatures of each group of runs, or differences of them [K]."""


@final
@dataclass(frozen=True)
class Bench:
    """A scene made ready to ask what is missing.

    - `coarse`: linear cells and few steps, what they make wrong added where it was measured last.
    - `finer`: the mesh [m] that they are measured against.
    - `memory`: of what was worked out before an interruption.
    - `scatter`: of scores by noise and by what `finer` leaves, over that by noise alone [1].
    """

    task: Task
    ready: Ready
    coarse: Objective
    finer: Mesh
    memory: Memory = Memory()
    scatter: float = 1.0

    def first(self, candidates: tuple[Candidate, ...]) -> Extended:
        """The point where the scene puts the fields, its candidates as they are [1]."""
        # Of one type throughout: what is only weakly typed would be another program once moved.
        point = Extended(start(self.coarse), candidates)
        return jax.tree.map(lambda leaf: jnp.asarray(leaf, leaf.dtype), point)


def set_up(task: Task) -> Bench:
    """Meshes [m] and programs of a task; nothing is measured yet."""
    stated = stand_in(task)
    # The mesher is a process of its own: both meshes are made at once.
    mesh, finer = at_once(lambda by: mesh_for(task, stated, by), (1.0, FINER))
    ready = lay_out(task, mesh, stated)
    return Bench(task, ready, _coarse(task, ready), finer)


def _coarse(task: Task, ready: Ready) -> Objective:
    """Linear cells and few steps, nothing added to what they read [K] yet."""
    made = coarse_tangents(task, ready)
    return with_remainders(made, [jnp.zeros_like(case.data) for case in made.cases])


def resolved(bench: Bench, edges: Points) -> Bench:
    """The bench with cells nearly as small as those that it is measured against [m].

    About `edges` [m], where what is inside is not what is outside, or light soon fades, they are
    smaller still, and of those that they are measured against as well.
    """
    task, stated = bench.task, bench.ready.stated
    if not len(edges):
        mesh, finer = mesh_for(task, stated, _SMALLER), bench.finer
    else:
        edge = _edge_about(edges, edge_of(bench) / _AT_EDGES, _MORE * len(bench.ready.mesh.nodes))
        near = ((Fine(edges, edge),), (Fine(edges, edge / _SMALLER),))
        wanted = (_SMALLER, near[0]), (FINER, near[1])
        mesh, finer = at_once(lambda one: mesh_for(task, stated, *one), wanted)
    ready = lay_out(task, mesh, stated)
    return replace(bench, ready=ready, coarse=_coarse(task, ready), finer=finer)


def _edge_about(edges: Points, wanted: float, most: float) -> float:
    """The least edge from `wanted` [m] on with which about `most` nodes do for all edges [1]."""
    low = edges.min(axis=0)
    while len(np.unique(np.floor((edges - low) / wanted), axis=0)) > most:
        wanted *= 1.2
    return wanted


def finest(bench: Bench) -> Bench:
    """The bench with smaller cells still to be measured against [m].

    As it is where the surface cannot be meshed so finely.
    """
    try:
        return replace(bench, finer=mesh_for(bench.task, bench.ready.stated, FINEST))
    except InputError:
        return bench


def edge_of(bench: Bench) -> float:
    """Edge of a regular tetrahedron as large as half of the cells [m]."""
    mesh = bench.ready.mesh
    corners = mesh.nodes[mesh.cells[:, :4]]
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    return float((6 * np.sqrt(2) * np.median(volume)) ** (1 / 3))


def steps_for(objective: Objective, point: Extended) -> Objective:
    """The objective with as many iterations a step as the point's candidates need [1]."""
    if not any(one.card.law for one in point.candidates):
        return objective
    return replace(objective, integrator=Sdirk2(iterations=2))


def corrected(bench: Bench, point: Extended, wanted: Apart) -> Bench:
    """The bench with all that its cells and steps make wrong at a point taken off [K].

    What they make wrong of temperatures is taken off before effects on the readings: a clock that
    is off, or a slow sensor, reads a body as it is. What is still wrong of readings, since those
    effects see fewer frames here, is taken off after them.

    `wanted`: what `finer_runs` reads there [K].
    """
    none = [jnp.zeros_like(one) for one in wanted]
    body = _unread(point)
    if body is not point:
        bench = corrected(bench, body, finer_runs(bench, body))
        bare = steps_for(with_remainders(bench.coarse, none), point)
        apart = _apart(bench.memory, wanted, bare, point)
        return replace(bench, coarse=with_remainders(bench.coarse, apart))
    # Where nothing is at work a program of the stated model does; else one serves all refits.
    if not _at_work(point):
        point = replace(point, candidates=())
    coarse = with_remainders(with_defects(bench.coarse, none), none)
    apart = _apart(bench.memory, wanted, steps_for(coarse, point), point)
    return replace(bench, coarse=with_defects(coarse, apart))


def _unread(point: Extended) -> Extended:
    """The point without effects on the readings [1]; itself where none is at work."""
    if not any(isinstance(one, AbstractReadingCandidate) for one in _at_work(point)):
        return point
    candidates = (
        replace(one, strength=jnp.zeros_like(one.strength))
        if isinstance(one, AbstractReadingCandidate)
        else one
        for one in point.candidates
    )
    return replace(point, candidates=tuple(candidates))


def usual_errors(bench: Bench, point: Extended, wanted: Apart) -> Apart:
    """By how much the finer runs differ from those of a fit's usual cells and steps [K].

    `wanted`: what `finer_runs` reads at the point, at which no candidate is at work [K].
    """
    usual = make_objective(bench.task, bench.ready, bench.task.meshing.order)
    return _apart(bench.memory, wanted, usual, replace(point, candidates=()))


def read_there(memory: Memory, objective: Objective, point: Extended) -> Apart:
    """What a point reads in the cases of an objective [K]."""
    found = memory.recalled(
        "reading", (objective, point), lambda: map(np.asarray, readings(objective, point))
    )
    return [jnp.asarray(one) for one in found]


def _apart(memory: Memory, wanted: Apart, objective: Objective, point: Extended) -> Apart:
    """Zero where a run has nothing."""
    found = read_there(memory, objective, point)
    return [jnp.nan_to_num(a - b) for a, b in zip(wanted, found, strict=True)]


def finer_runs(bench: Bench, point: Extended) -> Apart:
    """What a point reads on the finer mesh [K], laid out as the cases of the bench."""
    # What is absent changes nothing, and a smaller program compiles sooner.
    busy = _at_work(point)
    task, ready, like = bench.task, bench.ready, bench.coarse
    # Effects on the readings take no runs of their own.
    heat = tuple(one for one in busy if isinstance(one, AbstractHeatCandidate))
    here = ready, like, point.fields, bench.finer, heat
    made = bench.memory.lately(
        "finer", (task.key(), *here), lambda: finer_temperatures(task, *here)
    )
    return [jnp.asarray(one) for one in finer_readings(task, ready, like, made, busy)]


def _at_work(point: Extended) -> tuple[Candidate, ...]:
    """Candidates of any strength but zero."""
    return tuple(one for one in point.candidates if np.any(np.asarray(one.strength)))
