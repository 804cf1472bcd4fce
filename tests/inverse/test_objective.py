"""The whitened residual by hand, and its derivatives in every mode."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jax.flatten_util import ravel_pytree
from jaxtyping import Array

from thermo.fields import QUANTITIES, AbstractField
from thermo.inverse import OnControlPoints
from thermo.inverse._case import Case
from thermo.inverse._first_order import loss
from thermo.inverse._objective import (
    PAIRS,
    Objective,
    Parameters,
    case_temperatures,
    jacobian,
    neighbour_differences,
    penalty,
    residual,
    start,
    with_fields,
)
from thermo.inverse._reading_errors import whiten
from thermo.observe import Recording, Scene

from .objectives import MESH, beliefs, case, measured, moved, prior


@pytest.fixture(scope="module")
def cases(scene: Scene) -> list[Case]:
    """Two runs, the second with fewer frames and samples."""
    cooling = scene.runs["cooling"]
    old = cooling.recording
    part = Recording(old.points[:8], old.time[:9], old.temperature[:9, :8], old.valid[:9, :8])
    return [case(scene.runs["lamp"], 15.0), case(replace(cooling, recording=part), 15.0)]


@pytest.fixture(scope="module")
def objective(cases: list[Case]) -> Objective:
    return measured(cases)


@pytest.fixture(scope="module")
def point(objective: Objective) -> Parameters:
    return moved(objective)


@pytest.fixture(scope="module")
def pushed(objective: Objective, point: Parameters) -> tuple[np.ndarray, np.ndarray]:
    """The residual, and its slopes one tangent at a time, by one program."""
    flat, unravel = ravel_pytree(point)

    @jax.jit
    def push(way: Array) -> tuple[Array, Array]:
        return jax.jvp(lambda p: residual(objective, unravel(p)), (flat,), (way,))

    found = [push(way) for way in jnp.eye(3)]
    return np.asarray(found[0][0]), np.stack([np.asarray(slope) for _, slope in found], axis=1)


@pytest.fixture(scope="module")
def value(pushed: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    return pushed[0]


@pytest.fixture(scope="module")
def dense(objective: Objective, point: Parameters) -> tuple[np.ndarray, np.ndarray]:
    found = eqx.filter_jit(jacobian)(objective, point)
    return np.asarray(found[0]), np.asarray(found[1])


def test_the_residual_is_misfit_times_weight_then_priors(
    objective: Objective, point: Parameters, value: np.ndarray, cases: list[Case]
) -> None:
    fields = with_fields(objective, point)
    place = 0
    solve = eqx.filter_jit(case_temperatures)
    for one in cases:
        simulated = np.asarray(solve(objective, fields, one))
        data = np.asarray(one.data)
        frames, samples = data.shape
        # Groups are padded to 21 frames and 30 samples; what is padded counts for nothing.
        padded = value[place : place + 21 * 30].reshape(21, 30)
        wanted = np.asarray(whiten(one.errors, one.used, jnp.asarray(simulated - data)))
        assert np.abs(wanted).max() > 10
        # Padded steps shorten no time, so that only the solver's tolerance differs.
        assert np.allclose(padded[:frames, :samples], wanted, rtol=0, atol=1e-6)
        assert np.all(padded[frames:] == 0) and np.all(padded[:, samples:] == 0)
        place += 21 * 30
    assert np.allclose(value[place:], np.asarray(penalty(objective, point)), rtol=1e-12)


def test_the_priors_by_hand() -> None:
    problem = beliefs()
    point = moved(problem)
    terms = []
    for name, field in with_fields(problem, point).items():
        prior = problem.priors[name]
        log = np.log(np.asarray(field.control_values()))
        i, j = np.asarray(prior.pairs).T
        terms += [(log[i] - log[j]) / 0.3]
        terms += [[(log.mean() - np.log(float(prior.centre))) / 0.1]]
        terms += [np.sqrt(0.3) * np.asarray(point[name])]
    assert np.allclose(np.asarray(penalty(problem, point)), np.concatenate(terms), rtol=1e-12)


def test_the_jacobian_agrees_with_one_tangent_at_a_time(
    pushed: tuple[np.ndarray, np.ndarray], dense: Any
) -> None:
    value, columns = pushed
    assert np.allclose(dense[0], value, rtol=0, atol=1e-6)
    assert dense[1].shape == (len(value), 3)
    scale = np.abs(dense[1]).max()
    for number, column in enumerate(columns.T):
        assert np.abs(column).max() > 1e-3 * scale
        assert np.abs(dense[1][:, number] - column).max() < 1e-8 * scale


def test_the_gradient_agrees_with_the_jacobian(
    objective: Objective, point: Parameters, dense: Any
) -> None:
    slope = eqx.filter_jit(eqx.filter_grad(lambda p, o: loss(o, p)))(point, objective)
    wanted = dense[1].T @ dense[0]
    assert np.abs(np.asarray(slope["conductivity"]) - wanted).max() < 1e-6 * np.abs(wanted).max()


def test_fields_with_the_starting_parameters_are_the_fields(objective: Objective) -> None:
    again = with_fields(objective, start(objective))["conductivity"]
    assert np.array_equal(
        np.asarray(again.cell_values()), np.asarray(objective.fields["conductivity"].cell_values())
    )


@pytest.fixture(scope="module")
def varied() -> AbstractField:
    field, _ = OnControlPoints(count=4).make(QUANTITIES["conductivity"], MESH, 0.5, 0)
    return field.with_parameters(jnp.asarray([0.1, -0.4, 0.7, 0.0]))


@given(count=st.integers(0, 130), more=st.integers(0, 130))
def test_pairs_that_fill_up_cost_nothing_and_keep_shapes(
    varied: AbstractField, count: int, more: int
) -> None:
    rows = {}
    for number in (count, count + more):
        pairs = np.stack([np.arange(number) % 4, (np.arange(number) + 1) % 4], axis=1)
        filled = prior(pairs, 0.8)
        apart = np.asarray(eqx.filter_jit(neighbour_differences)(filled, varied))
        rows[number] = len(apart)
        values = np.asarray(varied.smooth_values())
        assert apart[:number] == pytest.approx(values[pairs[:, 0]] - values[pairs[:, 1]])
        assert not apart[number:].any() and len(apart) < number + PAIRS
        # Filling up again changes nothing.
        assert replace(filled, step=jnp.asarray(0.1)).pairs.shape == filled.pairs.shape
    same = -(-count // PAIRS) == -(-(count + more) // PAIRS)
    assert (rows[count] == rows[count + more]) == same
