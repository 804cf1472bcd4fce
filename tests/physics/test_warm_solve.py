"""Solves that begin from their neighbours in time: same answers, sooner, in three directions."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.mesh import box_mesh
from thermo.physics import ConjugateGradient, Model, StepMatrix, discretise
from thermo.physics._balance import assemble, step_matrix
from thermo.physics._outlook import AHEAD, BACK, DEPTH, MOST, Memory, Outlook, outlooks
from thermo.physics._warm_solve import tangent_solve, warm_solve

SPACE = discretise(box_mesh((0.02, 0.02, 0.01), (5, 5, 3)))
NODES, CELLS = len(SPACE.mesh.nodes), len(SPACE.mesh.cells)
TIGHT, LOOSE = ConjugateGradient(rtol=1e-13), ConjugateGradient(rtol=1e-13, max_steps=0)
SIZE = 0.5


def matrix() -> StepMatrix:
    model = Model(SPACE, jnp.full(CELLS, 3.0), jnp.full(CELLS, 2e6))
    return step_matrix(assemble(model), jnp.full(NODES, 300.0), 5.0)


def outlook() -> Outlook:
    return Outlook(
        jnp.array([2.0, -1.0, 0.0]), jnp.array([3.0, -3.0, 1.0]), jnp.asarray(SIZE), jnp.asarray(1)
    )


def random(seed: int, *shape: int) -> jax.Array:
    return jnp.asarray(np.random.default_rng(seed).normal(size=shape))


WHICH, OTHER = jnp.asarray(1), 7.0


def memory(found: jax.Array, largest: float = 0.0) -> Memory:
    """Of two solves, the second of which is looked at."""
    return Memory(jnp.stack([jnp.full_like(found, OTHER), found]), jnp.array([OTHER, largest]))


def test_the_past_holds_the_latest_rate_at_its_place() -> None:
    heat, past = random(0, NODES), random(1, DEPTH, NODES)
    found, later, fine = warm_solve(matrix(), heat, memory(past), WHICH, TIGHT, outlook())
    assert bool(fine)
    np.testing.assert_allclose(matrix().mv(found), heat, atol=1e-11)
    np.testing.assert_allclose(later.found[1, 1], found / SIZE, rtol=1e-14)
    np.testing.assert_array_equal(later.found[1, ::2], past[::2])
    np.testing.assert_array_equal(later.found[0], OTHER)
    np.testing.assert_array_equal(later.largest, [OTHER, 0.0])


@pytest.mark.parametrize("transposed", [False, True])
def test_a_past_that_points_to_the_solution_leaves_nothing_to_do(transposed: bool) -> None:
    heat, slope = random(2, NODES), random(3, NODES)
    wanted = jnp.linalg.solve(matrix().as_matrix(), heat)
    # Values on a line, or a parabola for the adjoint, that go on to the solution.
    places = jnp.arange(1, DEPTH + 1)[:, None]
    scale, bend = (1.0, 0.3) if transposed else (SIZE, 0.0)
    past = (wanted + slope * places + bend * slope * places**2) / scale

    def solve(heat: jax.Array, past: jax.Array, solver: ConjugateGradient) -> jax.Array:
        if not transposed:
            return warm_solve(matrix(), heat, memory(past), WHICH, solver, outlook())[0]

        def pair(b: jax.Array, before: Memory) -> tuple[jax.Array, Memory]:
            return tangent_solve(matrix(), b, before, WHICH, solver, outlook())[:2]

        # The adjoint's past is what the later steps hand back.
        return jax.linear_transpose(pair, heat, memory(past))((heat, memory(past)))[0]

    for solver in (TIGHT, LOOSE):
        got = solve(heat, past, solver)
        np.testing.assert_allclose(got, wanted, atol=1e-9 * float(jnp.abs(wanted).max()))
    assert float(jnp.abs(solve(heat, 0 * past, LOOSE)).max()) == 0.0


def test_a_small_tangent_is_known_as_well_as_the_largest_one() -> None:
    heat, nothing = random(8, NODES), jnp.zeros((DEPTH, NODES))
    solver, norm = ConjugateGradient(rtol=1e-6), 1 / matrix().diagonal
    size = float(heat @ (norm * heat))
    exact = jnp.linalg.solve(matrix().as_matrix(), heat)
    for factor, largest, digits in ((1.0, 0.0, 1e-6), (1e-3, size, 1e-3), (1e-7, size, 1.0)):
        found, later, fine = tangent_solve(
            matrix(), factor * heat, memory(nothing, largest), WHICH, solver, outlook()
        )
        left = factor * heat - matrix().mv(found)
        assert bool(fine) and float(left @ (norm * left)) <= (1.01e-6) ** 2 * size
        assert float(jnp.abs(found / factor - exact).max()) < 10 * digits * jnp.abs(exact).max()
        np.testing.assert_allclose(later.largest[1], max(largest, factor**2 * size))
    # What is below the tolerance of the largest one is not solved for at all.
    assert not np.any(found)


def test_batches_equal_single_solves() -> None:
    heat, past = random(4, 3, NODES), random(5, 3, DEPTH, NODES)

    def solve(b: jax.Array, before: jax.Array) -> tuple[jax.Array, Memory]:
        return tangent_solve(matrix(), b, memory(before), WHICH, TIGHT, outlook())[:2]

    together = jax.jit(jax.vmap(solve))(heat, past)
    shared = jax.jit(jax.vmap(solve, in_axes=(0, None)))(heat, past[0])
    for number in range(3):
        alone = solve(heat[number], past[number])
        many = jax.tree.map(lambda a, i=number: a[i], together)
        for mine, one in zip(jax.tree.leaves(many), jax.tree.leaves(alone), strict=True):
            np.testing.assert_allclose(mine, one, rtol=1e-12, atol=1e-10)
        np.testing.assert_allclose(shared[0][number], alone[0], rtol=0, atol=1e-10)


def test_batches_of_matrices_are_solved_one_by_one() -> None:
    heat, past = random(6, NODES), memory(random(7, DEPTH, NODES))
    weights = jnp.array([1.0, 5.0])
    model = Model(SPACE, jnp.full(CELLS, 3.0), jnp.full(CELLS, 2e6))
    balance = assemble(model)

    def solve(weight: jax.Array) -> jax.Array:
        at = step_matrix(balance, jnp.full(NODES, 300.0), weight)
        return warm_solve(at, heat, past, WHICH, TIGHT, outlook())[0]

    together = jax.jit(jax.vmap(solve))(weights)
    for number, weight in enumerate(weights):
        np.testing.assert_allclose(together[number], solve(weight), rtol=0, atol=1e-10)


def polynomial(time: np.ndarray, degree: int) -> np.ndarray:
    return np.polyval([0.3, -1.0, 2.0][2 - degree :], time)


@pytest.mark.parametrize("growth", [1.0, 1.1])
def test_outlooks_carry_polynomials_on(growth: float) -> None:
    size = 0.1 * growth ** np.arange(12)
    start = np.concatenate([[0.0], np.cumsum(size)[:-1]])
    middle = start + size / 2
    view = outlooks(jnp.asarray(start), jnp.asarray(size))
    ahead, back, place = (np.asarray(part) for part in (view.ahead, view.back, view.place))
    line, bend = polynomial(middle, AHEAD - 1), polynomial(middle, BACK - 1)
    held = np.zeros(DEPTH)
    for step in range(12):
        if step >= AHEAD:
            assert ahead[step] @ held == pytest.approx(line[step])
        held[place[step]] = line[step]
    held = np.zeros(DEPTH)
    for step in reversed(range(12)):
        if step < 12 - BACK:
            assert back[step] @ held == pytest.approx(bend[step])
        held[place[step]] = bend[step]
    # Where there is nothing to look back at there is no guess, after one step a constant.
    assert not ahead[0].any() and not back[-1].any()
    np.testing.assert_allclose(ahead[1], np.eye(DEPTH)[place[0]])
    np.testing.assert_allclose(back[-2], np.eye(DEPTH)[place[-1]])


def test_outlooks_do_not_carry_far() -> None:
    size = np.array([1.0, 1e-6, 1e-6, 1.0, 1.0, 1e-9, 1.0])
    start = np.concatenate([[0.0], np.cumsum(size)[:-1]])
    view = outlooks(jnp.asarray(start), jnp.asarray(size))
    for weights in (np.asarray(view.ahead), np.asarray(view.back)):
        assert np.isfinite(weights).all() and (np.abs(weights).sum(1) <= MOST).all()
