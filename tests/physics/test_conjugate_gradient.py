"""Conjugate gradients from a first guess: what it changes, and what it must not."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.mesh import box_mesh
from thermo.physics import ConjugateGradient, Model, StepMatrix, discretise
from thermo.physics._balance import assemble, step_matrix

SPACE = discretise(box_mesh((0.02, 0.02, 0.01), (5, 5, 3)))
NODES, CELLS = len(SPACE.mesh.nodes), len(SPACE.mesh.cells)
HEAT = jnp.asarray(np.random.default_rng(0).normal(size=NODES))
RTOL = 1e-6


def matrix() -> StepMatrix:
    model = Model(SPACE, jnp.full(CELLS, 3.0), jnp.full(CELLS, 2e6))
    return step_matrix(assemble(model), jnp.full(NODES, 300.0), 5.0)


def exact() -> np.ndarray:
    return np.linalg.solve(np.asarray(matrix().as_matrix()), np.asarray(HEAT))


@jax.jit
def _solve(guess: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    return ConjugateGradient(rtol=RTOL).solve(matrix(), HEAT, guess)


def solved(guess: np.ndarray) -> tuple[np.ndarray, bool]:
    found, fine, _ = _solve(jnp.asarray(guess))
    return np.asarray(found), bool(fine)


def iterations(guess: np.ndarray) -> int:
    return int(_solve(jnp.asarray(guess))[2])


def test_a_good_guess_saves_iterations_and_a_perfect_one_all() -> None:
    wanted = exact()
    near = wanted + 1e-4 * np.abs(wanted).max() * np.asarray(HEAT)
    assert iterations(wanted) == 0 < iterations(near) < iterations(np.zeros(NODES))
    for guess in (wanted, near, np.zeros(NODES)):
        assert np.abs(solved(guess)[0] - wanted).max() < 1e-5 * np.abs(wanted).max()


@pytest.mark.parametrize("scale", [-3.0, 0.0, 0.9, 100.0])
def test_only_the_direction_of_a_guess_counts(scale: float) -> None:
    found, fine = solved(scale * exact())
    assert fine and iterations(scale * exact()) == (0 if scale else iterations(np.zeros(NODES)))
    operator = matrix()
    left = np.asarray(HEAT) - np.asarray(operator.as_matrix()) @ found
    norm = 1 / np.asarray(operator.diagonal)
    assert (left * norm) @ left <= (1.01 * RTOL) ** 2 * ((np.asarray(HEAT) * norm) @ HEAT)


def test_a_guess_that_misleads_costs_no_more_than_a_few_iterations() -> None:
    wrong = np.random.default_rng(1).normal(size=NODES) * 1e6
    assert iterations(wrong) <= iterations(np.zeros(NODES)) + 2
    np.testing.assert_allclose(solved(wrong)[0], exact(), atol=1e-5 * np.abs(exact()).max())


def test_columns_are_solved_as_if_alone() -> None:
    heat = jnp.stack([HEAT, 1e-8 * HEAT[::-1], jnp.zeros(NODES)], axis=1)
    solver = ConjugateGradient(rtol=RTOL)
    together, fine, _ = solver.solve(matrix(), heat, jnp.zeros_like(heat))
    assert bool(fine)
    assert not np.any(together[:, 2])
    for column in range(2):
        alone, *_ = solver.solve(matrix(), heat[:, column], jnp.zeros(NODES))
        scale = float(jnp.abs(alone).max())
        np.testing.assert_allclose(together[:, column], alone, atol=1e-9 * scale)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-12])
@pytest.mark.parametrize("conductivity", [3.0, 3e5])
def test_single_precision_inside_keeps_the_tolerance(rtol: float, conductivity: float) -> None:
    make = np.random.default_rng(3)
    model = Model(SPACE, jnp.full(CELLS, conductivity), jnp.full(CELLS, 2e6))
    operator = step_matrix(assemble(model), jnp.full(NODES, 300.0), 5.0)
    # Rough, and what constant temperatures ask for, which is the hardest, of all sizes.
    rough, even = make.normal(size=NODES), np.asarray(operator.mv(jnp.ones(NODES)))
    heat = jnp.asarray(np.stack([1e-25 * rough, even, 1e25 * rough, 1e-25 * even], 1))
    norm = 1 / np.asarray(operator.diagonal)[:, None]
    size = np.sum(heat * norm * heat, 0)
    guess = jnp.asarray(make.normal(size=heat.shape))
    solver = ConjugateGradient(rtol=rtol)
    found, fine, _ = jax.jit(solver.solve_together)(operator, heat, guess, jnp.zeros(4))
    left = np.asarray(heat - operator.mv(found))
    assert bool(fine) and found.dtype == heat.dtype
    reached = np.sqrt(np.sum(left * norm * left, 0) / size)
    assert (reached < rtol + 1e-14 * np.sqrt(np.sum(found**2 / norm, 0) / size)).all(), reached


def test_nothing_wanted_is_found_at_once_together() -> None:
    nothing = jnp.zeros((NODES, 2))
    found, fine, steps = ConjugateGradient().solve_together(
        matrix(), nothing, nothing + 1.0, jnp.zeros(2)
    )
    assert bool(fine) and int(steps) == 0
    np.testing.assert_array_equal(found, nothing)
