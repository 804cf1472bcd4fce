"""Heat is neither made nor lost, and a body at rest stays at rest."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.mesh import box_mesh, mesh_from_cells, promote
from thermo.physics import (
    ConjugateGradient,
    Discretisation,
    Model,
    assemble,
    discretise,
    heat_rate,
    solve_heat,
    stored_heat,
    uniform_steps,
)
from thermo.physics._balance import equivalent
from thermo.physics._outlook import without_past
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
    patch_profile,
    spot_profile,
)
from thermo.physics.integrators import AbstractIntegrator, BackwardEuler, Sdirk2
from thermo.physics.integrators._sdirk2 import GAMMA, _stages

TIGHT = ConjugateGradient(rtol=1e-12)
simulate = eqx.filter_jit(solve_heat)


def wedge(order: int) -> Discretisation:
    plain = box_mesh((0.03, 0.02, 0.02), (2, 1, 1))
    x, y, z = plain.nodes.T
    mesh = mesh_from_cells(np.stack([x + 0.3 * y, y + 5 * x * z, z + 0.1 * x], 1), plain.cells)
    return discretise(mesh if order == 1 else promote(mesh))


def body(order: int, *, laws: bool) -> Model:
    """Every effect that knows its own flux, uneven over the body."""
    space = wedge(order)
    cells, faces = len(space.mesh.cells), len(space.mesh.faces)
    make = np.random.default_rng(3)
    ambient = History(jnp.array([0.0, 4.0, 30.0]), jnp.array([280.0, 310.0, 290.0]))
    lamp = spot_profile(
        space, centre=np.array([0.02, 0.01, 0.0]), direction=np.array([0.2, 0, -1]), radius=0.01
    )
    return Model(
        space,
        jnp.asarray(make.uniform(0.3, 3.0, cells)),
        jnp.asarray(make.uniform(1e6, 2e6, cells)),
        surface=(
            Convection(jnp.asarray(make.uniform(5, 30, faces)), ambient),
            Radiation(jnp.asarray(make.uniform(0.2, 0.9, faces)), 270.0),
            Contact(jnp.asarray(make.uniform(0, 50, faces)), 285.0),
            Heating(4.0, lamp, Schedule(11.0, 3.0)),
            PrescribedFlux(jnp.asarray(make.uniform(0, 500, faces))),
        ),
        volume=(VolumetricSource(jnp.asarray(make.uniform(1e4, 1e5, cells)), Schedule(8.0)),),
        conductivity_law=PolynomialLaw(jnp.array([1.0, 4e-3]), 300.0) if laws else None,
        capacity_law=PolynomialLaw(jnp.array([1.0, 2e-3, 1e-5]), 300.0) if laws else None,
    )


@eqx.filter_jit
def step_and_inflow(model: Model, scheme: AbstractIntegrator, old, start, size):
    """One step, the heat that it stored and the heat that its own quadrature let in [J]."""
    balance = assemble(model)
    last = start + size * (1 - 1e-9)
    if isinstance(scheme, Sdirk2):
        before = without_past(scheme.solves(), len(old))
        new, rise, *_ = _stages(scheme, balance, old, start, size, TIGHT, *before, jax.lax.scan)
        first = heat_rate(balance, old + rise, start + GAMMA * size)
        flow = (1 - GAMMA) * first + GAMMA * heat_rate(balance, new, last)
    else:
        before = without_past(scheme.solves(), len(old))
        new, *_ = scheme.step(balance, old, start, size, TIGHT, *before, jax.lax.scan)
        flow = heat_rate(balance, new, last)
    change = equivalent(balance, new) - equivalent(balance, old)
    return new, stored_heat(balance, change).sum(), size * flow.sum()


@pytest.mark.parametrize(
    ("order", "laws", "scheme"),
    [(1, False, Sdirk2(iterations=3)), (2, True, BackwardEuler(iterations=6))],
)
def test_stored_heat_is_what_flowed_in(order: int, laws: bool, scheme: AbstractIntegrator) -> None:
    model = body(order, laws=laws)
    grid = uniform_steps(np.array([5.0, 20.0]), 1.0, (8.0, 11.0))
    state = jnp.full(len(model.space.mesh.nodes), 295.0)
    start, size = jnp.asarray(grid.start), jnp.asarray(grid.size)
    gained, let_in, moved = 0.0, 0.0, 0.0
    for place in range(len(grid.start)):
        state, stored, flowed = step_and_inflow(model, scheme, state, start[place], size[place])
        gained, let_in, moved = gained + stored, let_in + flowed, moved + abs(flowed)
    assert abs(gained - let_in) < 1e-8 * moved
    if order == 1:
        initial = jnp.full(len(state), 295.0)
        whole = simulate(model, initial, grid, integrator=scheme, solver=TIGHT)
        np.testing.assert_allclose(whole.final, state, rtol=0, atol=1e-9)


@pytest.mark.parametrize("order", [1, 2])
def test_a_lamp_gives_its_power_while_it_is_on(order: int) -> None:
    space = wedge(order)
    mesh = space.mesh
    spot = spot_profile(
        space, centre=np.zeros(3), direction=np.array([0.0, 0.0, 2.0]), radius=0.008
    )
    patch = patch_profile(space, np.flatnonzero(mesh.normals[:, 2] > 0.9))
    for profile in (spot, patch):
        assert abs((profile * space.face_weight).sum() - 1) < 1e-12
    lamps = (Heating(5.0, spot, Schedule(7.0)), Heating(2.0, patch, Schedule(3.0)))
    capacity = jnp.full(len(mesh.cells), 2e6)
    model = Model(space, jnp.ones(len(mesh.cells)), capacity, lamps)
    grid = uniform_steps(np.array([10.0]), 0.5, (3.0, 7.0))
    initial = jnp.full(len(mesh.nodes), 300.0)
    solution = simulate(model, initial, grid, integrator=Sdirk2(), solver=TIGHT)
    stored = float(stored_heat(assemble(model), solution.final - initial).sum())
    assert abs(stored / (5.0 * 7.0 + 2.0 * 3.0) - 1) < 1e-10


def test_a_lamp_that_misses_the_body_is_refused() -> None:
    with pytest.raises(ValueError, match="does not meet"):
        spot_profile(
            wedge(1), centre=np.array([9.0, 9, 9]), direction=np.array([0, 0, 1.0]), radius=0.01
        )


def test_a_lamp_lights_only_what_faces_it() -> None:
    space = wedge(1)
    axis = np.array([0.0, 0.6, -0.8])
    profile = spot_profile(space, centre=space.mesh.nodes.mean(0), direction=axis, radius=0.01)
    facing = space.mesh.normals @ axis
    assert (profile[facing >= 0] == 0).all()
    assert (profile[facing < 0] > 0).all()


def test_schedule_warms_up_and_cools_down() -> None:
    slow, sharp = Schedule(10.0, 2.0), Schedule(10.0)
    at = jax.vmap(slow.share)(jnp.array([-1.0, 0.0, 2.0, 10.0, 12.0]))
    top = 1 - np.exp(-5)
    np.testing.assert_allclose(at, [0, 0, 1 - np.exp(-1), top, top * np.exp(-1)], rtol=1e-14)
    on = jax.vmap(sharp.share)(jnp.array([-1.0, 0.0, 9.999, 10.0, 12.0]))
    np.testing.assert_array_equal(on, [0, 1, 1, 0, 0])


@pytest.mark.parametrize(
    ("order", "scheme"), [(1, Sdirk2()), (2, Sdirk2()), (2, BackwardEuler(iterations=2))]
)
def test_a_body_in_equilibrium_stays_to_the_last_bit(
    order: int, scheme: AbstractIntegrator
) -> None:
    level = 293.17
    space = wedge(order)
    cells, faces = len(space.mesh.cells), len(space.mesh.faces)
    make = np.random.default_rng(4)
    history = History(jnp.array([0.0, 3.0]), jnp.full(2, level))
    held = np.where(space.mesh.nodes[:, 0] > 0.03, 0, -1)
    model = Model(
        space,
        jnp.asarray(make.uniform(0.3, 3.0, cells)),
        jnp.asarray(make.uniform(1e2, 2e6, cells)),
        surface=(
            Convection(jnp.asarray(make.uniform(5, 3000, faces)), level),
            Radiation(jnp.asarray(make.uniform(0.2, 0.9, faces)), level),
            LaggedRadiation(jnp.asarray(make.uniform(0.2, 0.9, faces)), level),
            Contact(jnp.asarray(make.uniform(0, 5000, faces)), history),
        ),
        prescribed=PrescribedTemperature(jnp.asarray(held), (history,)),
        conductivity_law=PolynomialLaw(jnp.array([1.0, 4e-3]), 300.0),
        capacity_law=PolynomialLaw(jnp.array([1.0, 2e-3, 1e-5]), 300.0),
    )
    initial = jnp.full(len(space.mesh.nodes), level)
    solution = simulate(model, initial, uniform_steps(np.array([400.0]), 40.0), integrator=scheme)
    np.testing.assert_array_equal(solution.final, initial)
