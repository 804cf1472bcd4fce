"""A small box under a lamp or without one, and what is read of it with candidates at work."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from thermo.discover import Candidate, Place
from thermo.inverse import Conditions
from thermo.inverse._addition import extend, read_as
from thermo.inverse._conditions import conditions, make_model
from thermo.inverse._properties import Stated, properties
from thermo.mesh import box_mesh
from thermo.observe import Heater, Recording, Run
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
STATED = Stated(conductivity=0.8, capacity=1.54e6, convection=25.0, emissivity=0.4)
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
    quiet: bool = False,
) -> Run:
    """A run whose readings are noise about the temperature that it begins at [K]."""
    noise = np.random.default_rng(len(time)).normal(0, 0.02, (len(time) + 6, len(POINTS)))
    data = initial + noise
    record = Recording(POINTS, time, data[6:], quiet=data[:6] if quiet else None)
    return Run(name, record, initial, AIR, AIR, None if lamp is None else Heater(**lamp))


@cache
def hot() -> Conditions:
    """Hot at first, without a lamp."""
    return conditions(run(initial=HOT), SPACE)


@cache
def resting() -> Conditions:
    """As warm as the air, without a lamp."""
    return conditions(run(), SPACE)


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


_solve = eqx.filter_jit(solve_heat)


def solved(model: Model, under: Conditions, scheme: Sdirk2 | None = None) -> Values:
    """Temperatures of a model at every node [K], (frames, nodes).

    Models of one structure share a program, whatever their numbers are.
    """
    scheme = steps_of(model) if scheme is None else scheme
    first = under.start(len(NODES))
    found = _solve(model, first, GRID, integrator=scheme, solver=SOLVER)
    assert bool(found.converged)
    return np.asarray(found.temperature)


def body_readings(candidates: tuple[Candidate, ...], under: Conditions) -> Values:
    """What is read at every node [K], (frames, nodes), with candidates at work."""
    body = jnp.asarray(solved(extend(bare(under), under, candidates), under))
    return np.asarray(_read(body, under, candidates))


def _read(body: jax.Array, under: Conditions, candidates: tuple[Candidate, ...]) -> jax.Array:
    return read_as(body, jnp.asarray(FRAMES), under, jnp.zeros(body.shape[1]), candidates)


@cache
def without(initial: float, power: float, iterations: int) -> Values:
    """Temperatures without candidates [K], from a start [K] under a lamp of a power [W]."""
    under = lit(power=power) if power else conditions(run(initial=initial), SPACE)
    return solved(bare(under), under, Sdirk2(iterations=iterations))


def change(candidate: Candidate, under: Conditions) -> Values:
    """By how much a candidate changes what is read [K], (frames, nodes)."""
    # Another number of iterations is another scheme.
    iterations = 2 if candidate.card.law else 1
    before = without(float(under.initial), float(under.power), iterations)
    return body_readings((candidate,), under) - before


def order_of_remainder(
    make: Callable[[jax.Array], Candidate],
    under: Conditions,
    where: jax.Array,
    way: jax.Array,
) -> float:
    """Order in h of what a derivative of the readings along a way leaves over [1].

    Arguments: `make`: from strengths to a candidate; `where`: strengths, `way`: a change of them,
    each in the card's unit.
    """

    def readings(strength: jax.Array) -> jax.Array:
        candidate = make(strength)
        model = extend(bare(under), under, (candidate,))
        first = under.start(len(NODES))
        body = solve_heat(model, first, GRID, integrator=steps_of(model), solver=SOLVER)
        return _read(body.temperature, under, (candidate,))

    # One program for values and slopes.
    push = jax.jit(lambda strength, way: jax.jvp(readings, (strength,), (way,)))
    value, slope = push(where, way)
    assert float(jnp.abs(slope).max()) > 1e-3
    shares = 0.5 ** np.arange(1, 5)
    rest = [jnp.linalg.norm(push(where + h * way, way)[0] - value - h * slope) for h in shares]
    return float(np.polyfit(np.log(shares), np.log(rest), 1)[0])


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


def one(value: float) -> jax.Array:
    """One strength."""
    return jnp.asarray([value])
