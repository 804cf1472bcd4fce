"""Derivatives of a whole run, forward and reverse, by every input that can be unknown."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.extend.core import jaxprs_in_params

from thermo._compiled import _options
from thermo.mesh import box_mesh, promote
from thermo.physics import (
    AbstractAdjoint,
    ConjugateGradient,
    Discretisation,
    ForwardOnly,
    Model,
    RecomputeSegments,
    StoreSteps,
    discretise,
    solve_heat,
    uniform_steps,
)
from thermo.physics.effects import (
    Contact,
    Convection,
    Heating,
    History,
    LaggedRadiation,
    PolynomialLaw,
    PrescribedFlux,
    PrescribedTemperature,
    Radiation,
    Schedule,
    VolumetricSource,
    spot_profile,
)
from thermo.physics.integrators import AbstractIntegrator, BackwardEuler, Sdirk2

Inputs = dict[str, Any]
SOLVER = ConjugateGradient(rtol=1e-14)
# As programs of the package are compiled, which takes a sixth less.
jit = partial(jax.jit, compiler_options=_options())
INTEGRATORS = {"backward_euler": BackwardEuler(iterations=2), "sdirk2": Sdirk2()}
ORDERS = {BackwardEuler: 2, Sdirk2: 1}
NAMES = (
    "conductivity capacity convection ambient emissivity lagged_emissivity surroundings power "
    "contact flux source prescribed conductivity_law capacity_law initial"
).split()
SHARES = 0.5 ** np.arange(2, 7)


@cache
def space(order: int) -> Discretisation:
    if order == 2:
        return discretise(promote(box_mesh((0.02, 0.02, 0.01), (1, 1, 1))))
    return discretise(box_mesh((0.02, 0.02, 0.01), (2, 2, 1)))


@cache
def inputs(order: int) -> Inputs:
    mesh = space(order).mesh
    make = np.random.default_rng(0)
    cells, faces, nodes = len(mesh.cells), len(mesh.faces), len(mesh.nodes)
    root = make.normal(size=(cells, 3, 3))
    values = {
        "conductivity": root @ np.swapaxes(root, 1, 2) / 3 + np.eye(3),
        "capacity": make.uniform(1e6, 2e6, cells),
        "convection": make.uniform(5, 30, faces),
        "ambient": np.array(285.0),
        "emissivity": make.uniform(0.3, 0.9, faces),
        "lagged_emissivity": make.uniform(0.3, 0.9, faces),
        "surroundings": np.array(280.0),
        "power": np.array(3.0),
        "contact": make.uniform(20, 60, faces),
        "flux": make.uniform(1e3, 4e3, faces),
        "source": make.uniform(1e5, 5e5, cells),
        "prescribed": make.uniform(300, 320, 4),
        "conductivity_law": np.array([1.0, 4e-3]),
        "capacity_law": np.array([1.0, 2e-3, 1e-5]),
        "initial": make.uniform(295, 305, nodes),
    }
    return {name: jnp.asarray(value) for name, value in values.items()}


def temperatures(
    given: Inputs, integrator: AbstractIntegrator, adjoint: AbstractAdjoint
) -> jax.Array:
    """Frames of a run in which every kind of effect takes part."""
    body = space(ORDERS[type(integrator)])
    lamp = spot_profile(
        body, centre=np.array([0.01, 0.01, 0.01]), direction=np.array([0, 0, -1.0]), radius=0.01
    )
    held = np.where(body.mesh.nodes[:, 0] < 1e-9, 0, -1)
    history = History(jnp.array([0.0, 5.0, 12.0, 30.0]), given["prescribed"])
    model = Model(
        body,
        given["conductivity"],
        given["capacity"],
        surface=(
            Convection(given["convection"], given["ambient"]),
            Radiation(given["emissivity"], given["surroundings"]),
            LaggedRadiation(given["lagged_emissivity"], given["surroundings"]),
            Heating(given["power"], lamp, Schedule(11.0, 2.0)),
            Contact(given["contact"], 290.0),
            PrescribedFlux(given["flux"]),
        ),
        volume=(VolumetricSource(given["source"], Schedule(8.0)),),
        prescribed=PrescribedTemperature(jnp.asarray(held), (history,)),
        conductivity_law=PolynomialLaw(given["conductivity_law"], 300.0),
        capacity_law=PolynomialLaw(given["capacity_law"], 300.0),
    )
    grid = uniform_steps(np.array([4.0, 12.0, 20.0]), 3.0, (8.0, 11.0))
    return solve_heat(
        model, given["initial"], grid, integrator=integrator, solver=SOLVER, adjoint=adjoint
    ).temperature


def weighed(found: jax.Array) -> jax.Array:
    weight = 1 + jnp.sin(jnp.arange(found.size)).reshape(found.shape)
    return jnp.sum(weight * (found - 295) ** 2) / found.size


def loss(given: Inputs, integrator: AbstractIntegrator, adjoint: AbstractAdjoint) -> jax.Array:
    return weighed(temperatures(given, integrator, adjoint))


@cache
def compiled(scheme: str) -> tuple[Callable, Callable]:
    """The loss with its gradient, and the frames with their derivative along a direction."""
    integrator = INTEGRATORS[scheme]

    def value(given: Inputs) -> jax.Array:
        return loss(given, integrator, StoreSteps())

    def along(given: Inputs, direction: Inputs) -> tuple[jax.Array, jax.Array]:
        def frames(given: Inputs) -> jax.Array:
            return temperatures(given, integrator, StoreSteps())

        return jax.jvp(frames, (given,), (direction,))

    return jit(jax.value_and_grad(value)), jit(along)


def direction_of(name: str, given: Inputs) -> Inputs:
    """A change of one input by about its own size, of temperatures by tens of kelvin."""
    level = given[name]
    noise = jnp.asarray(np.random.default_rng(1).uniform(0.5, 1.0, level.shape))
    kelvin = name in ("initial", "prescribed", "ambient", "surroundings")
    step = 40 * noise if kelvin else level * noise
    if name == "conductivity":
        step = (step + jnp.swapaxes(step, 1, 2)) / 2
    return {key: step if key == name else jnp.zeros_like(value) for key, value in given.items()}


def moved(given: Inputs, direction: Inputs, share: float) -> Inputs:
    return jax.tree.map(lambda a, b: a + share * b, given, direction)


def order_of_remainder(value: Callable, given: Inputs, direction: Inputs, slope: float) -> float:
    start = value(given)
    rest = [abs(float(value(moved(given, direction, s)) - start - s * slope)) for s in SHARES]
    return float(np.polyfit(np.log(SHARES), np.log(rest), 1)[0])


@pytest.mark.parametrize("scheme", list(INTEGRATORS))
@pytest.mark.parametrize("name", NAMES)
def test_taylor_remainder(name: str, scheme: str) -> None:
    value_and_gradient, along = compiled(scheme)
    given = inputs(ORDERS[type(INTEGRATORS[scheme])])
    assert sorted(given) == sorted(NAMES)
    direction = direction_of(name, given)
    forward = jax.jvp(weighed, *((each,) for each in along(given, direction)))[1]
    _, back = value_and_gradient(given)
    reverse = sum(jnp.vdot(back[key], direction[key]) for key in direction)
    assert abs(float(forward)) > 1e-3
    np.testing.assert_allclose(forward, reverse, rtol=1e-10)

    def value(given: Inputs) -> jax.Array:
        return value_and_gradient(given)[0]

    assert order_of_remainder(value, given, direction, float(reverse)) > 1.9


def test_both_adjoints_give_the_same_gradient() -> None:
    kept, _ = compiled("sdirk2")
    again = jit(jax.grad(lambda given: loss(given, INTEGRATORS["sdirk2"], RecomputeSegments(3))))
    one, other = kept(inputs(1))[1], again(inputs(1))
    for name in one:
        tolerance = 1e-12 * float(jnp.abs(one[name]).max())
        np.testing.assert_allclose(one[name], other[name], rtol=0, atol=tolerance, err_msg=name)


@pytest.mark.parametrize("scheme", list(INTEGRATORS))
def test_tangents_in_a_batch_and_side_by_side_equal_single_ones(scheme: str) -> None:
    names = ("ambient", "surroundings", "power", "source", "capacity")
    integrator = INTEGRATORS[scheme]
    given = inputs(ORDERS[type(integrator)])
    _, along = compiled(scheme)

    def frames(factor: jax.Array, adjoint: AbstractAdjoint) -> jax.Array:
        changed = {name: given[name] * factor[i] for i, name in enumerate(names)}
        return temperatures(given | changed, integrator, adjoint)

    ones = jnp.ones(len(names))
    plain, wide = (
        jit(jax.jacfwd(lambda f, a=adjoint: frames(f, a)))(ones)
        for adjoint in (StoreSteps(), ForwardOnly())
    )
    still = jax.tree.map(jnp.zeros_like, given)
    for column, name in enumerate(names):
        _, alone = along(given, still | {name: given[name]})
        scale = float(jnp.abs(alone).max())
        assert scale > 1e-3
        for many in (plain, wide):
            np.testing.assert_allclose(many[..., column], alone, rtol=0, atol=1e-11 * scale)


def test_a_batch_of_runs_may_be_forward_only() -> None:
    given = inputs(1)
    _, along = compiled("sdirk2")

    def pushed(power: jax.Array) -> tuple[jax.Array, jax.Array]:
        def run(value: jax.Array) -> jax.Array:
            return temperatures(given | {"power": value}, Sdirk2(), ForwardOnly())

        return jax.jvp(run, (power,), (jnp.ones(()),))

    powers = jnp.array([1.0, 4.0])
    together = jit(jax.vmap(pushed))(powers)
    way = jax.tree.map(jnp.zeros_like, given) | {"power": jnp.ones(())}
    for number, power in enumerate(powers):
        for many, one in zip(together, along(given | {"power": power}, way), strict=True):
            np.testing.assert_allclose(many[number], one, rtol=0, atol=1e-9)


def solves_in(jaxpr: Any) -> list[str]:
    """For each linear solve that a program writes down, what it is for."""
    found = []
    for equation in jaxpr.eqns:
        if equation.primitive.name == "warm_solve":
            found.append(equation.params["role"])
        for inner in jaxprs_in_params(equation.params):
            found += solves_in(inner)
    return found


def test_the_reverse_pass_repeats_no_solve() -> None:
    program = jax.make_jaxpr(jax.grad(lambda given: loss(given, Sdirk2(), StoreSteps())))(inputs(1))
    solves = solves_in(program.jaxpr)
    assert solves.count("value") == Sdirk2().solves() == solves.count("adjoint")
    assert len(solves) == 2 * Sdirk2().solves()


def test_a_jacobian_writes_down_a_stage_once() -> None:
    given = inputs(1)

    def push(way: jax.Array) -> jax.Array:
        def run(power: jax.Array) -> jax.Array:
            return temperatures(given | {"power": power}, Sdirk2(), ForwardOnly())

        return jax.jvp(run, (given["power"],), (way,))[1]

    program = jax.make_jaxpr(jax.vmap(push))(jnp.ones(3))
    assert sorted(solves_in(program.jaxpr)) == ["tangent", "value"]


def test_a_run_is_traced_once() -> None:
    traces = 0

    @eqx.filter_jit
    def run(given: Inputs) -> jax.Array:
        nonlocal traces
        traces += 1
        return temperatures(given, Sdirk2(), StoreSteps())

    first = run(inputs(1))
    second = run(moved(inputs(1), direction_of("power", inputs(1)), 0.1))
    assert traces == 1
    assert float(jnp.abs(first - second).max()) > 1e-3
