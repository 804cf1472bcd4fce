"""A preconditioner's part in coarser spaces: the same solutions, sooner where heat goes far."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.mesh import box_mesh, promote
from thermo.physics import (
    ConjugateGradient,
    Discretisation,
    Model,
    StepMatrix,
    _coarse_spaces,
    discretise,
    solve_heat,
    uniform_steps,
)
from thermo.physics._balance import assemble, step_matrix
from thermo.physics._coarse_correction import coarse_matrices
from thermo.physics.effects import Convection, History, PrescribedTemperature
from thermo.physics.integrators import Sdirk2

CAPACITY, METAL = 2e6, 200.0
LONG, SHORT = 50.0, 1e-4
"""Weights [s] in which heat goes through the whole body, and not through a cell."""


@pytest.fixture(scope="module", params=[1, 2])
def space(request: pytest.FixtureRequest) -> Discretisation:
    """A bar of linear or quadratic cells, with coarser spaces though it is small."""
    linear = box_mesh((0.04, 0.01, 0.01), (16, 4, 4) if request.param == 1 else (12, 3, 3))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_coarse_spaces, "LEAST_NODES", 0)
        return discretise(linear if request.param == 1 else promote(linear), 1.0)


def body(space: Discretisation, **beside: object) -> Model:
    cells = len(space.mesh.cells)
    along = jnp.asarray(np.linspace(0.5, 2.0, cells))
    return Model(space, METAL * along, jnp.full(cells, CAPACITY), **beside)  # type: ignore[arg-type]


def held_at_an_end(space: Discretisation) -> PrescribedTemperature:
    end = np.asarray(space.mesh.nodes)[:, 0] < 1e-9
    return PrescribedTemperature(
        jnp.asarray(np.where(end, 0, -1)),
        (History(jnp.array([0.0, 1.0]), jnp.array([310.0, 310.0])),),
    )


@eqx.filter_jit
def matrix(model: Model, weight: float | jax.Array = LONG) -> StepMatrix:
    warm = jnp.full(len(model.space.mesh.nodes), 300.0)
    return step_matrix(assemble(model), warm, weight)


def plain(operator: StepMatrix) -> StepMatrix:
    return eqx.tree_at(lambda one: one.coarse, operator, None)


def cooled(space: Discretisation, transfer: float) -> Model:
    faces = len(space.mesh.faces)
    return body(space, surface=(Convection(jnp.full(faces, transfer), jnp.asarray(290.0)),))


def bodies(space: Discretisation) -> dict[str, Model]:
    return {
        "alone": body(space),
        "air": cooled(space, 10.0),
        "water": cooled(space, 1e4),
        "held": body(space, prescribed=held_at_an_end(space)),
    }


@pytest.mark.parametrize("tensor", [False, True])
def test_matrices_are_those_of_the_fine_one_in_the_coarser_spaces(
    space: Discretisation, tensor: bool
) -> None:
    model = body(space)
    if tensor:
        turn = jnp.asarray([[2.0, 0.5, 0.0], [0.5, 1.0, 0.2], [0.0, 0.2, 3.0]])
        model = eqx.tree_at(
            lambda m: m.conductivity, model, model.conductivity[:, None, None] * turn
        )
    made, spaces = coarse_matrices(space, model.conductivity, model.capacity), space.coarse
    assert made is not None and spaces is not None
    carry = np.asarray(spaces.nodes(jnp.eye(len(spaces.part))))
    sums = np.asarray(spaces.sums(jnp.eye(len(spaces.part))))
    none, fine = (np.asarray(matrix(model, jnp.asarray(w)).as_matrix()) for w in (0.0, 1.0))
    for whole, diagonal, parts in (
        (none, made.stored, made.stored_parts),
        (fine - none, made.stiffness, made.stiffness_parts),
    ):
        linear = carry.T @ whole @ carry
        atol = 1e-10 * np.abs(linear).max()
        np.testing.assert_allclose(diagonal, np.diag(linear), atol=atol)
        np.testing.assert_allclose(parts, sums @ linear @ sums.T, atol=10 * atol)


@pytest.mark.parametrize("kind", ["alone", "air", "water", "held"])
def test_it_is_symmetric_and_positive(space: Discretisation, kind: str) -> None:
    operator = matrix(bodies(space)[kind])
    assert operator.coarse is not None and bool(operator.coarse.worth)
    dense = np.asarray(operator.coarse.apply(jnp.eye(len(space.mesh.nodes))))
    np.testing.assert_allclose(dense, dense.T, atol=1e-12 * np.abs(dense).max())
    values = np.linalg.eigvalsh(dense)
    assert values.min() > -1e-14 * values.max()


@pytest.mark.parametrize("kind", ["alone", "air", "water", "held"])
def test_solutions_are_the_same_in_fewer_iterations(space: Discretisation, kind: str) -> None:
    model = bodies(space)[kind]
    operator = matrix(model)
    heat = np.random.default_rng(0).normal(size=len(space.mesh.nodes))
    if model.prescribed is not None:
        heat = heat * np.asarray(model.prescribed.free())
    heat = jnp.asarray(heat)
    wanted = np.linalg.solve(np.asarray(operator.as_matrix()), heat)
    solve = jax.jit(lambda one: ConjugateGradient(rtol=1e-10).solve(one, heat, 0 * heat))
    (found, fine, count), (_, _, usual) = solve(operator), solve(plain(operator))
    assert bool(fine) and int(count) < 0.8 * int(usual), (int(count), int(usual))
    np.testing.assert_allclose(found, wanted, atol=1e-7 * np.abs(wanted).max())
    many = jnp.stack([heat, heat[::-1] * (heat != 0)], 1)
    together = jax.jit(ConjugateGradient(rtol=1e-8).solve_together)
    side, fine, _ = together(operator, many, 0 * many, jnp.zeros(2))
    assert bool(fine)
    np.testing.assert_allclose(side[:, 0], wanted, atol=1e-5 * np.abs(wanted).max())


def test_a_short_step_goes_as_without(space: Discretisation) -> None:
    operator = matrix(body(space), SHORT)
    heat = jnp.asarray(np.random.default_rng(0).normal(size=len(space.mesh.nodes)))
    solve = jax.jit(lambda one: ConjugateGradient(rtol=1e-10).solve(one, heat, 0 * heat))
    (found, _, count), (usual, _, usually) = solve(operator), solve(plain(operator))
    assert operator.coarse is not None and not bool(operator.coarse.worth)
    assert int(count) == int(usually)
    np.testing.assert_allclose(found, usual, rtol=1e-12, atol=1e-12 * float(jnp.abs(usual).max()))


def test_a_run_and_its_derivatives_are_the_same(space: Discretisation) -> None:
    # Steps of one length have a matrix that is made but once.
    even = space.order == 1
    ends = np.linspace(0.0, 100.0, 6) if even else np.array([0.0, 1.0, 5.0, 30.0, 100.0])
    grid = uniform_steps(ends, 20.0 if even else 100.0)
    assert grid.even == even
    warm = jnp.full(len(space.mesh.nodes), 330.0)

    @eqx.filter_jit
    def run(space: Discretisation, factor: jax.Array) -> jax.Array:
        model = cooled(space, 200.0)
        model = eqx.tree_at(lambda m: m.conductivity, model, factor * model.conductivity)
        made = solve_heat(
            model, warm, grid, integrator=Sdirk2(), solver=ConjugateGradient(rtol=1e-11)
        )
        return made.temperature[:, ::50]

    bare = eqx.tree_at(lambda one: one.coarse, space, None)
    factors = jnp.asarray([0.1, 1.0])

    def with_slope(space: Discretisation, factor: jax.Array) -> jax.Array:
        return jnp.stack(jax.jvp(lambda f: run(space, f), (factor,), (jnp.ones(()),)))

    for derived in (
        # Values and slopes of one program, which takes long to compile.
        lambda one: jax.vmap(lambda f: with_slope(one, f))(factors).reshape(4, -1),
        lambda one: jax.grad(lambda f: jnp.sum(run(one, f)[-1]))(factors[0]).reshape(1, 1),
    ):
        wanted, found = np.asarray(derived(bare)), np.asarray(derived(space))
        for one, other in zip(found, wanted, strict=True):
            np.testing.assert_allclose(one, other, atol=1e-6 * np.abs(other).max())
