"""Conjugate gradients from a first guess: what it changes, and what it must not."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import lineax as lx
import numpy as np
import pytest

from thermo.mesh import box_mesh
from thermo.physics import ConjugateGradient, Model, SparseOperator, discretise
from thermo.physics._balance import assemble, step_matrix
from thermo.physics.integrators._integrator import rates, solve_increment

SPACE = discretise(box_mesh((0.02, 0.02, 0.01), (5, 5, 3)))
NODES, CELLS = len(SPACE.mesh.nodes), len(SPACE.mesh.cells)
HEAT = jnp.asarray(np.random.default_rng(0).normal(size=NODES))
RTOL = 1e-6


def matrix(conductivity: float | jax.Array = 3.0) -> SparseOperator:
    model = Model(SPACE, jnp.full(CELLS, conductivity), jnp.full(CELLS, 2e6))
    return step_matrix(assemble(model), jnp.full(NODES, 300.0), 5.0)


def exact() -> np.ndarray:
    return np.linalg.solve(np.asarray(matrix().as_matrix()), np.asarray(HEAT))


def solved(guess: np.ndarray | None) -> tuple[np.ndarray, int]:
    options = {} if guess is None else {"y0": jnp.asarray(guess)}
    solution = lx.linear_solve(matrix(), HEAT, ConjugateGradient(rtol=RTOL), options=options)
    return np.asarray(solution.value), int(solution.stats["num_steps"])


def test_a_good_guess_saves_iterations_and_a_perfect_one_all() -> None:
    wanted = exact()
    cold, most = solved(None)
    warm, fewer = solved(wanted * 1.001)
    same, none = solved(wanted)
    assert none == 0 < fewer < most
    for found in (cold, warm, same):
        assert np.abs(found - wanted).max() < 1e-5 * np.abs(wanted).max()


@pytest.mark.parametrize("scale", [-3.0, 0.0, 0.9, 100.0])
def test_the_tolerance_is_relative_to_the_heat_whatever_the_guess(scale: float) -> None:
    found, _ = solved(scale * exact())
    operator = matrix()
    left = np.asarray(HEAT) - np.asarray(operator.as_matrix()) @ found
    norm = 1 / np.asarray(operator.diagonal)
    # Rounding of a guess that is far off is all that comes on top.
    bound = RTOL + 1e-14 * abs(scale)
    assert (left * norm) @ left <= (1.01 * bound) ** 2 * ((np.asarray(HEAT) * norm) @ HEAT)


def test_the_derivative_does_not_know_the_guess() -> None:
    tight = ConjugateGradient(rtol=1e-12)

    def probe(conductivity: jax.Array, guess: jax.Array) -> jax.Array:
        return jnp.sum(HEAT * solve_increment(matrix(conductivity), HEAT, tight, guess)[0])

    at = jnp.asarray(3.0)
    far, near = 5.0 * jnp.ones(NODES), jnp.asarray(exact())
    slopes = [jax.grad(probe, argnums=(0, 1))(at, guess) for guess in (far, near)]
    pushed = jax.jvp(lambda k: probe(k, far), (at,), (jnp.ones(()),))[1]
    step = 1e-4
    difference = (probe(at + step, far) - probe(at - step, far)) / (2 * step)
    for slope, by_guess in slopes:
        assert slope == pytest.approx(float(pushed), rel=1e-9)
        assert slope == pytest.approx(float(difference), rel=1e-6)
        assert not np.any(by_guess)


def test_steps_of_no_duration_leave_no_rates() -> None:
    rise = jnp.ones((2, 3))
    assert np.array_equal(rates(rise, 0.5), 2 * np.ones((2, 3)))
    assert np.array_equal(rates(rise, 0.0), np.zeros((2, 3)))
