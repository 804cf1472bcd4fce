"""A small box under a lamp or without one, and what is read of it with candidates at work."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from thermo.discover import Candidate, Inclusion, Place
from thermo.inverse import Conditions
from thermo.inverse._addition import extend, read_as
from thermo.inverse._conditions import conditions, make_model
from thermo.inverse._properties import Stated, properties
from thermo.mesh import box_mesh
from thermo.observe import Box, Heater, Recording, Run
from thermo.physics import (
    ConjugateGradient,
    Model,
    assemble,
    discretise,
    heat_rate,
    solve_heat,
    uniform_steps,
)
from thermo.physics.integrators import Sdirk2

Values = NDArray[np.float64]

SIZE = (0.020, 0.012, 0.008)  # m
MESH = box_mesh(SIZE, (3, 2, 2))
SPACE = discretise(MESH)
# Of the discretised body, which numbers its nodes in an order of its own [m].
NODES = np.asarray(SPACE.mesh.nodes)
# Cells of this size resolve what goes on in a body that conducts as well as this.
STATED = Stated(conductivity=3.0, capacity=1.54e6, convection=25.0, emissivity=0.4)
AIR, HOT = 295.0, 335.0  # K
OFF = 15.0  # s, when the lamp goes off
FRAMES = np.linspace(0.0, 24.0, 9)  # s
GRID = uniform_steps(FRAMES, 3.0, (OFF,))
LAMP: dict[str, Any] = {
    "centre": [0.013, 0.006, 0.02],
    "direction": [0, 0, -1],
    "radius": 0.005,
    "power": 1.2,
    "until": OFF,
}
# Points on the top, on a side and on an end [m].
POINTS = np.array(
    [[0.013, 0.006, 0.008], [0.004, 0.004, 0.008], [0.009, 0.0, 0.003], [0.02, 0.006, 0.004]]
)
# Far below what any test calls a difference.
SOLVER = ConjugateGradient(rtol=1e-13)


def run(
    name: str = "rest",
    *,
    initial: float = AIR,
    lamp: dict[str, Any] | None = None,
    time: Values = FRAMES,
    points: Values = POINTS,
    quiet: bool = False,
) -> Run:
    """A run whose readings are noise about the temperature that it begins at [K]."""
    noise = np.random.default_rng(len(time)).normal(0, 0.02, (len(time) + 6, len(points)))
    data = initial + noise
    record = Recording(points, time, data[6:], quiet=data[:6] if quiet else None)
    return Run(name, record, initial, AIR, AIR, None if lamp is None else Heater(**lamp))


@cache
def hot() -> Conditions:
    """Hot at first, without a lamp."""
    return conditions(run(initial=HOT), SPACE)


@cache
def resting() -> Conditions:
    """As warm as the air, without a lamp."""
    return conditions(run(), SPACE)


@cache
def wrapped() -> Conditions:
    """Hot at first, all of it insulated."""
    whole = Box([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0])
    return conditions(replace(run(initial=HOT), insulated=(whole,)), SPACE)


def lit(**changes: Any) -> Conditions:
    """Under the lamp, as warm as the air at first; `changes` are of the lamp."""
    return conditions(run(lamp={**LAMP, **changes}), SPACE)


def bare(under: Conditions, stated: Stated = STATED) -> Model:
    """The body without candidates."""
    body = properties(stated, {}, len(SPACE.mesh.cells), len(SPACE.mesh.faces))
    return make_model(SPACE, body, under)


def steps_of(model: Model) -> Sdirk2:
    """The scheme with as many iterations a stage as the model needs."""
    laws = model.conductivity_law is not None or model.capacity_law is not None
    return Sdirk2(iterations=2 if laws else 1)


# Of small bodies and few steps, programs take longer to compile than to run.
QUICKLY = {"xla_backend_optimization_level": 0}


_solve = eqx.filter_jit(solve_heat, compiler_options=QUICKLY)  # pyright: ignore[reportCallIssue]


def solved(model: Model, under: Conditions) -> Values:
    """Temperatures of a model at every node [K], (frames, nodes).

    Models of one structure share a program, whatever their numbers are.
    """
    # Numbers that are weakly typed, as made of a float, would make a program of their own.
    arrays, others = eqx.partition(model, eqx.is_array)
    model = eqx.combine(jax.tree.map(lambda leaf: jnp.asarray(leaf, leaf.dtype), arrays), others)
    first = under.start(len(NODES))
    found = _solve(model, first, GRID, integrator=steps_of(model), solver=SOLVER)
    assert bool(found.converged)
    return np.asarray(found.temperature)


# Linear without a law, so that one iteration a stage is exact there as two are.
DARK = replace(STATED, emissivity=0.0)


@cache
def without(initial: float, power: float, stated: Stated = STATED) -> Values:
    """Temperatures without candidates [K], from a start [K] under a lamp of a power [W]."""
    under = lit(power=power) if power else conditions(run(initial=initial), SPACE)
    return solved(bare(under, stated), under)


def change(candidate: Candidate, under: Conditions) -> Values:
    """By how much a candidate changes what is read at every node [K], (frames, nodes)."""
    stated = DARK if candidate.card.law else STATED
    body = jnp.asarray(solved(extend(bare(under, stated), under, (candidate,)), under))
    pinned = jnp.zeros(len(NODES))
    read = read_as(body, jnp.asarray(FRAMES), under, pinned, (candidate,))
    return np.asarray(read) - without(float(under.initial), float(under.power), stated)


def power_into(model: Model, level: float, time: float) -> float:
    """Heat that flows into a body of one temperature [K] at a time [s]: [W]."""
    return float(_power_into(model, jnp.full(len(NODES), level), jnp.asarray(time)))


@eqx.filter_jit
def _power_into(model: Model, temperature: jax.Array, time: jax.Array) -> jax.Array:
    return jnp.sum(heat_rate(assemble(model), temperature, time))


def nearest(place: tuple[float, float, float]) -> int:
    """Number of the node nearest to a place [m]."""
    return int(np.argmin(((NODES - np.array(place)) ** 2).sum(1)))


def at(place: tuple[float, float, float], size: float) -> Place:
    """One place [m]."""
    return Place(jnp.asarray(place)[None], jnp.asarray([size]))


def within(
    where: tuple[float, float, float],
    size: float | list[float],
    squareness: float = 4.0,
    sharpness: float = 8.0,
) -> Inclusion:
    """A body within the body, of one size or of one along each axis [m]."""
    sizes = jnp.broadcast_to(jnp.asarray(size), (1, 3))
    return Inclusion(
        jnp.asarray([where]), sizes, jnp.asarray([squareness]), jnp.asarray([sharpness])
    )


def one(value: float) -> jax.Array:
    """One strength."""
    return jnp.asarray([value])
