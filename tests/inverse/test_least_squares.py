"""The stop of Levenberg-Marquardt and of Gauss-Newton: no sooner and no later than it should."""

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

from thermo.inverse import AbstractOptimiser, GaussNewtonKrylov, LevenbergMarquardt
from thermo.inverse import _least_squares as least_squares
from thermo.inverse._minimise import minimise
from thermo.inverse._objective import FieldPrior, Objective, Parameters, jacobian, start

from .objectives import at, beliefs

BOTH = [LevenbergMarquardt(max_steps=20), GaussNewtonKrylov(max_steps=20)]


def scaled(problem: Objective, factor: float) -> dict[str, FieldPrior]:
    """The problem's priors with residuals `factor` times as large."""
    return {
        name: replace(
            prior,
            step=prior.step / factor,
            spread=prior.spread / factor,
            decay=prior.decay * factor**2,
        )
        for name, prior in problem.priors.items()
    }


def sharpened(factor: float) -> Objective:
    """Beliefs whose residuals are all `factor` times as large."""
    problem = beliefs()
    return replace(problem, priors=scaled(problem, factor))


@pytest.mark.parametrize("optimiser", BOTH)
def test_a_fit_settles_where_little_is_promised(optimiser: AbstractOptimiser) -> None:
    fit = minimise([at(sharpened(100.0))], optimiser, key="x")
    strict = replace(sharpened(100.0), settled=1e-12, gain=1e-9)
    exact = minimise([at(strict)], optimiser, key="x")
    (history,) = fit.history
    left = fit.loss - exact.loss
    bound = max(0.05, 1e-4 * fit.loss)
    assert fit.success and 2 <= len(history) < len(exact.history[0])
    assert 0 <= left < 2 * bound
    # The step before still had something to gain.
    assert history[-2] - exact.loss > bound


def test_an_early_stage_ends_one_step_on_where_the_answer_is_near() -> None:
    strict = replace(sharpened(100.0), settled=0.0, gain=0.0)

    def fitted(near: float, steps: int) -> tuple[np.ndarray, list[float], bool]:
        objective = replace(strict, near=near)
        fit = minimise([at(objective)], LevenbergMarquardt(max_steps=steps), key="x")
        return np.asarray(ravel_pytree(fit.parameters)[0]), fit.history[0], fit.success

    wanted, usual, _ = fitted(0.0, 20)
    found, losses, success = fitted(0.05, 20)
    stood, *_ = fitted(0.0, len(losses))
    assert success and len(losses) < len(usual) and losses == usual[: len(losses)]
    # Where it stood was within such a step of the answer, and it went that step.
    assert 1e-6 < np.abs(stood - wanted).max() < 0.06
    assert np.abs(found - wanted).max() < 0.1 * np.abs(stood - wanted).max()


@pytest.mark.parametrize("optimiser", BOTH)
def test_running_out_of_steps_is_no_success(optimiser: AbstractOptimiser) -> None:
    fit = minimise([at(sharpened(100.0))], replace(optimiser, max_steps=2), key="x")
    assert not fit.success and len(fit.history[0]) == 2
    assert fit.loss == fit.history[0][1] < fit.history[0][0]


def test_a_step_uphill_is_refused_and_the_trust_shrinks() -> None:
    problem = beliefs()
    optimiser = GaussNewtonKrylov()
    begun = {name: field.parameters() for name, field in problem.fields.items()}
    point, state, first, _ = optimiser.advance(problem, begun, optimiser.begin(problem, begun))
    wild = replace(state, trial=state.trial + 50.0)
    stood, shrunk, second, (done, _) = optimiser.advance(problem, point, wild)
    assert float(second) == float(first) and not bool(done)
    assert all(jnp.array_equal(stood[name], point[name]) for name in point)
    assert float(shrunk.step) == pytest.approx(0.25 * float(state.step), rel=1e-12)


def steered(factor: float) -> Objective:
    """The beliefs, steered by tangents that are `factor` times the true ones."""
    problem = sharpened(100.0)
    return replace(problem, tangents=replace(problem, priors=scaled(problem, factor)))


def test_coarse_tangents_steer_to_the_same_minimum() -> None:
    exact = minimise([at(sharpened(100.0))], LevenbergMarquardt(), key="x")
    fit = minimise([at(steered(1.3))], LevenbergMarquardt(), key="x")
    bound = max(0.05, 1e-4 * fit.loss)
    assert fit.success
    # Tangents that are too long make the steps too short by a fixed share.
    assert abs(fit.loss - exact.loss) < 20 * bound
    assert fit.history[0][1] != pytest.approx(exact.history[0][1], rel=1e-6)


def test_tangents_that_point_uphill_stall_without_success() -> None:
    fit = minimise([at(steered(-1.0))], LevenbergMarquardt(), key="x")
    assert not fit.success
    assert len(fit.history[0]) == 1 + least_squares.STALLED < LevenbergMarquardt().max_steps
    assert len(set(fit.history[0])) == 1, "nothing uphill was taken"


@jax.jit
def _no_longer(move: Array, trust: Array) -> tuple[Array, Array]:
    return least_squares._longest(move, trust), least_squares._shortened(move, trust)


@given(
    move=st.lists(st.floats(-1e6, 1e6, allow_subnormal=False), min_size=1, max_size=6),
    share=st.floats(1e-6, 1e6),
)
def test_steps_are_shortened_and_more_where_trust_was_lost(move: list[float], share: float) -> None:
    trust = jnp.asarray(share * least_squares.FIRST_STEP)
    longest = max(map(abs, move))
    most = min(least_squares.LONGEST, longest) * min(1.0, share)
    left, short = map(np.asarray, _no_longer(jnp.asarray(move), trust))
    cut = np.clip(np.asarray(move), -left, left)
    expected = [np.sign(one) * min(abs(one), most) for one in move]
    np.testing.assert_allclose(cut, expected, rtol=1e-12)
    part = most / max(longest, 1e-12)
    np.testing.assert_allclose(short, np.asarray(move) * part, rtol=1e-9, atol=1e-300)


def near(matrix: np.ndarray, value: np.ndarray) -> Any:
    """The loss near a point with this residual and Jacobian [1]."""
    parts = map(jnp.asarray, np.linalg.eigh(matrix.T @ matrix))
    return least_squares._Near(jnp.asarray(value @ matrix), *parts)


@jax.jit
def _shortened_by(here: Any, share: float) -> tuple[Array, ...]:
    """The whole step, a share of it, the step within that, and what this and cutting promise."""
    trust = jnp.asarray(least_squares.FIRST_STEP)
    whole = here.damped(trust)
    most = share * jnp.abs(whole).max()
    step = here.within(most, trust)
    cut = jnp.minimum(1.0, share) * whole
    return whole, most, step, here.promise(step), here.promise(cut)


@given(seed=st.integers(0, 999), share=st.floats(1e-6, 2.0))
def test_the_damping_is_the_least_that_keeps_a_step_short(seed: int, share: float) -> None:
    make = np.random.default_rng(seed)
    here = near(make.normal(size=(30, 4)) * [1e-3, 1.0, 20.0, 5.0], make.normal(size=30))
    whole, most, step, promised, cut = _shortened_by(here, share)
    if share >= 1:
        np.testing.assert_allclose(step, whole, rtol=1e-9)
    else:
        assert float(jnp.abs(step).max()) == pytest.approx(float(most), rel=1e-6)
    assert float(promised) >= float(cut) * (1 - 1e-9)


def test_where_nothing_is_to_be_gained_nothing_moves() -> None:
    here = near(np.eye(3), np.zeros(3))
    within = jax.jit(lambda most, trust: here.within(most, trust))
    step = within(jnp.asarray(0.0), jnp.asarray(least_squares.FIRST_STEP))
    assert np.array_equal(step, np.zeros(3))


def test_a_direction_that_is_hardly_known_holds_up_no_other() -> None:
    # Only the sum of both is known well, and it is off by 1; their difference is said to be 40 off.
    matrix = np.array([[300.0, 300.0], [0.3, -0.3]])
    here = near(matrix, -matrix @ np.array([20.5, -19.5]))
    bounded = jax.jit(lambda trust: least_squares._BoundedDescent().step(trust, here)[0])
    step = bounded(jnp.asarray(least_squares.FIRST_STEP))
    assert np.abs(step).max() <= least_squares.LONGEST
    assert step.sum() == pytest.approx(1.0, abs=1e-3), "the sum goes all its way"
    distrusted = bounded(jnp.asarray(1.0))
    assert np.abs(distrusted).max() == pytest.approx(0.01, rel=1e-6)


def test_the_whole_step_promises_the_least_of_the_model() -> None:
    make = np.random.default_rng(1)
    matrix, value = make.normal(size=(30, 4)), make.normal(size=30)
    here = near(matrix, value)
    damped = np.linalg.solve(matrix.T @ matrix + np.eye(4) / 5.0, -matrix.T @ value)
    np.testing.assert_allclose(here.damped(5.0), damped, rtol=1e-12)
    best = np.linalg.lstsq(matrix, -value, rcond=None)[0]
    fall = 0.5 * (value @ value - np.sum((value + matrix @ best) ** 2))
    assert here.promise(jnp.asarray(best)) == pytest.approx(fall, rel=1e-12)
    assert here.most() == pytest.approx(fall, rel=1e-3)
    assert here.promise(jnp.asarray(0.3 * best)) < here.most()


def planned(state: Any, parameters: Parameters) -> np.ndarray:
    """The change of each parameter that the next trial is to make [1]."""
    trial = state.trial if hasattr(state, "trial") else state.y_eval
    return np.asarray(trial - ravel_pytree(parameters)[0])


@pytest.mark.parametrize("cutting", [True, False])
def test_only_a_dense_step_is_not_held_up_by_a_parameter_far_off(cutting: bool) -> None:
    optimiser = LevenbergMarquardt() if cutting else GaussNewtonKrylov(inner_rtol=1e-10)
    problem = beliefs(centre=2.0)
    begun = start(problem)
    point, state, _, _ = optimiser.advance(problem, begun, optimiser.begin(problem, begun))
    value, matrix = (np.asarray(part) for part in eqx.filter_jit(jacobian)(problem, begun))
    damped = matrix.T @ matrix + np.eye(matrix.shape[1]) / least_squares.FIRST_STEP
    whole = np.linalg.solve(damped, -matrix.T @ value)
    cut = np.abs(whole) > least_squares.LONGEST
    assert 0 < cut.sum() < len(whole) and 0 < np.abs(whole[~cut]).max() < 0.9
    longest = least_squares.LONGEST
    expected = np.clip(whole, -longest, longest) if cutting else whole * longest / abs(whole).max()
    np.testing.assert_allclose(planned(state, point), expected, rtol=1e-6)


def trials(objective: Objective) -> tuple[np.ndarray, np.ndarray]:
    """The loss after each step, and the longest change of a parameter in the trial after it [1]."""
    optimiser = LevenbergMarquardt()
    parameters, losses, lengths = start(objective), [], []
    state, done = optimiser.begin(objective, parameters), False
    while not done:
        parameters, state, loss, (ended, _) = optimiser.advance(objective, parameters, state)
        losses.append(float(loss))
        lengths.append(float(np.abs(planned(state, parameters)).max()))
        done = bool(ended)
    return np.asarray(losses), np.asarray(lengths)


def test_refused_steps_get_shorter() -> None:
    losses, lengths = trials(steered(-1.0))
    assert len(set(losses)) == 1
    expected = least_squares.LONGEST * least_squares.NARROW ** np.arange(len(lengths))
    np.testing.assert_allclose(lengths, expected, rtol=1e-12)


def test_a_refused_step_shorter_than_the_longest_is_not_tried_again() -> None:
    losses, lengths = trials(steered(0.45))
    refused = np.flatnonzero(np.diff(losses) == 0)
    assert len(refused) > 0 and lengths[refused[0]] < 0.5
    assert (lengths[refused + 1] < 0.9 * lengths[refused]).all()


def test_with_coarse_tangents_a_small_gain_ends_a_fit() -> None:
    share = 0.01
    exact = minimise([at(sharpened(100.0))], LevenbergMarquardt(), key="x")
    slow = replace(steered(5.0), settled=share)
    fit = minimise([at(slow)], LevenbergMarquardt(max_steps=100), key="x")
    (history,) = np.asarray(fit.history)
    gains = -np.diff(history) / history[1:]
    assert fit.success and 3 < len(history) < 100
    assert 0 < gains[-1] < share and (gains[:-1] > share).all()
    # What the tangents promised was still more than that.
    assert fit.loss - exact.loss > share * fit.loss > 0.05


@pytest.mark.parametrize("share", [1.0, 0.1])
def test_a_small_gain_ends_no_fit_whose_step_was_short_for_lack_of_trust(share: float) -> None:
    # Tangents a hundred times too long: what they promise stays large, what a step gains is small.
    objective, optimiser = replace(steered(100.0), settled=0.0), LevenbergMarquardt()
    parameters = start(objective)
    state = optimiser.begin(objective, parameters)
    trust = jnp.asarray(share * least_squares.FIRST_STEP)
    state = eqx.tree_at(lambda one: one.search_state.step_size, state, trust)
    parameters, state, before, _ = optimiser.advance(objective, parameters, state)
    _, _, after, _ = optimiser.advance(objective, parameters, state)
    gain = float(before - after)
    for enough, ended in ((1.5 * gain / share, True), (0.7 * gain / share, False)):
        asked = replace(objective, gain=enough)
        _, last, _, (done, fine) = optimiser.advance(asked, parameters, state)
        assert 0 < gain < last.descent_state.most()
        assert bool(done) is bool(fine) is ended


def test_a_second_fit_of_the_same_shapes_traces_no_step_anew(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    traced: list[Objective] = []
    dense = least_squares._dense

    def counted(objective: Objective, parameters: Parameters) -> Any:
        traced.append(objective)
        return dense(objective, parameters)

    monkeypatch.setattr(least_squares, "_dense", counted)
    # Numbers of runs that no other test has, so that none has compiled this program before.
    first = replace(sharpened(17.0), sequence=(17,))
    other = replace(sharpened(19.0), sequence=(17,), settled=3.7e-4)
    optimiser = LevenbergMarquardt(max_steps=20)
    one, two = (minimise([at(problem)], optimiser, key="x") for problem in (first, other))
    assert one.success and two.success and two.loss > one.loss
    assert len(traced) == 1
