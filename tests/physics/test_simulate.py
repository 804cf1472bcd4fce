"""What a run keeps: prescribed nodes, frames, failures of the linear solver."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.mesh import box_mesh
from thermo.physics import (
    ConjugateGradient,
    Model,
    ReadOut,
    TimeGrid,
    assemble,
    discretise,
    solve_heat,
    step_matrix,
    uniform_steps,
)
from thermo.physics.effects import Convection, History, PrescribedTemperature
from thermo.physics.integrators import Sdirk2

simulate = eqx.filter_jit(solve_heat)
FRAMES = np.array([0.0, 3.0, 7.0, 10.0])


def bar(*, held: bool) -> Model:
    space = discretise(box_mesh((0.05, 0.01, 0.01), (5, 1, 1)))
    x = space.mesh.nodes[:, 0]
    patch = np.where(x < 1e-9, 0, np.where(x > 0.05 - 1e-9, 1, -1))
    histories = (
        History(jnp.array([0.0, 4.0, 10.0]), jnp.array([300.0, 340.0, 310.0])),
        History(jnp.array([2.0, 8.0]), jnp.array([300.0, 280.0])),
    )
    cells = len(space.mesh.cells)
    return Model(
        space,
        jnp.full(cells, 2.0),
        jnp.full(cells, 1e6),
        surface=(Convection(jnp.full(len(space.mesh.faces), 15.0), 330.0),),
        prescribed=PrescribedTemperature(jnp.asarray(patch), histories) if held else None,
    )


def test_prescribed_nodes_follow_their_histories() -> None:
    model = bar(held=True)
    initial = jnp.full(len(model.space.mesh.nodes), 300.0)
    solution = simulate(model, initial, uniform_steps(FRAMES, 0.5), integrator=Sdirk2())
    found = np.asarray(solution.temperature)
    patch = np.asarray(model.prescribed.patch)
    first = np.interp(FRAMES, [0, 4, 10], [300, 340, 310])
    second = np.interp(FRAMES, [2, 8], [300, 280])
    np.testing.assert_allclose(found[:, patch == 0], first[:, None] + np.zeros(4), atol=1e-6)
    np.testing.assert_allclose(found[:, patch == 1], second[:, None] + np.zeros(4), atol=1e-6)
    assert np.ptp(found[-1, patch < 0]) > 5


def test_frames_and_readout() -> None:
    model = bar(held=False)
    count = len(model.space.mesh.nodes)
    initial = jnp.linspace(300.0, 320.0, count)
    grid = uniform_steps(FRAMES, 0.5)
    whole = simulate(model, initial, grid, integrator=Sdirk2())
    np.testing.assert_array_equal(whole.time, FRAMES)
    np.testing.assert_array_equal(whole.temperature[0], initial)
    np.testing.assert_array_equal(whole.temperature[-1], whole.final)
    nodes = np.array([[0, 3], [5, 5]], np.int32)
    weights = np.array([[0.25, 0.75], [1.0, 0.0]])
    part = simulate(model, initial, grid, integrator=Sdirk2(), readout=ReadOut(nodes, weights))
    expected = 0.25 * whole.temperature[:, 0] + 0.75 * whole.temperature[:, 3]
    np.testing.assert_allclose(part.temperature[:, 0], expected, rtol=1e-13)
    np.testing.assert_allclose(part.temperature[:, 1], whole.temperature[:, 5], rtol=1e-13)


def test_a_solver_that_stops_early_is_reported() -> None:
    model = bar(held=False)
    initial = jnp.full(len(model.space.mesh.nodes), 300.0)
    grid = uniform_steps(FRAMES, 0.5)
    good = simulate(model, initial, grid, integrator=Sdirk2())
    short = ConjugateGradient(rtol=1e-12, max_steps=2)
    bad = simulate(model, initial, grid, integrator=Sdirk2(), solver=short)
    assert bool(good.converged) and not bool(bad.converged)


@pytest.mark.parametrize("rtol", [1e-4, 1e-8, 1e-12])
def test_conjugate_gradient_meets_its_tolerance(rtol: float) -> None:
    model = bar(held=True)
    count = len(model.space.mesh.nodes)
    operator = step_matrix(assemble(model), jnp.full(count, 300.0), 5.0)
    heat = jnp.asarray(np.random.default_rng(0).normal(size=(3, count)))

    def solve(rhs: jax.Array) -> jax.Array:
        return ConjugateGradient(rtol=rtol).solve(operator, rhs, jnp.zeros_like(rhs))[0]

    exact = np.linalg.solve(np.asarray(operator.as_matrix()), np.asarray(heat).T).T
    together = np.asarray(jax.jit(solve)(heat.T)).T
    for batch, right in zip(together, exact, strict=True):
        rest = np.asarray(operator.as_matrix()) @ (batch - right)
        scale = np.asarray(operator.as_matrix()) @ right
        weight = 1 / np.asarray(operator.diagonal)
        assert (rest**2 @ weight) <= (1.01 * rtol) ** 2 * (scale**2 @ weight) + 1e-28
    alone = np.asarray(jax.jit(solve)(heat[0]))
    np.testing.assert_allclose(alone, together[0], atol=10 * rtol * np.abs(exact[0]).max())


@pytest.mark.parametrize("held", [False, True])
def test_even_steps_share_their_matrix_and_give_the_same(held: bool) -> None:
    model = bar(held=held)
    initial = jnp.full(len(model.space.mesh.nodes), 300.0)
    even = uniform_steps(np.array([5.0, 10.0]), 0.5)
    assert even.even
    odd = TimeGrid(even.start, even.size, even.frame_step, even.frame_time)
    assert not odd.even
    assert not uniform_steps(FRAMES, 0.7).even
    tight = ConjugateGradient(rtol=1e-12)
    found, expected = (
        simulate(model, initial, grid, integrator=Sdirk2(), solver=tight).temperature
        for grid in (even, odd)
    )
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)
    assert np.ptp(found) > 2
