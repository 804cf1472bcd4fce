"""The stop of Levenberg-Marquardt and of Gauss-Newton: no sooner and no later than it should."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import pytest

from thermo.inverse import AbstractOptimiser, GaussNewtonKrylov, LevenbergMarquardt
from thermo.inverse import _least_squares as least_squares
from thermo.inverse._minimise import minimise
from thermo.inverse._objective import FieldPrior, Objective

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
def test_a_fit_settles_where_little_is_promised(
    optimiser: AbstractOptimiser, monkeypatch: pytest.MonkeyPatch
) -> None:
    fit = minimise([at(sharpened(100.0))], optimiser, key="x")
    monkeypatch.setattr(least_squares, "SETTLED", 1e-9)
    jax.clear_caches()
    exact = minimise([at(replace(sharpened(100.0), settled=1e-12))], optimiser, key="x")
    jax.clear_caches()
    (history,) = fit.history
    left = fit.loss - exact.loss
    bound = max(0.05, 1e-4 * fit.loss)
    assert fit.success and 2 <= len(history) < len(exact.history[0])
    assert 0 <= left < 2 * bound
    # The step before still had something to gain.
    assert history[-2] - exact.loss > bound


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
    bound = max(least_squares.SETTLED, 1e-4 * fit.loss)
    assert fit.success
    # Tangents that are too long make the steps too short by a fixed share.
    assert abs(fit.loss - exact.loss) < 20 * bound
    assert fit.history[0][1] != pytest.approx(exact.history[0][1], rel=1e-6)


def test_tangents_that_point_uphill_stall_without_success() -> None:
    fit = minimise([at(steered(-1.0))], LevenbergMarquardt(), key="x")
    assert not fit.success
    assert len(fit.history[0]) == 1 + least_squares.STALLED < LevenbergMarquardt().max_steps
    assert len(set(fit.history[0])) == 1, "nothing uphill was taken"
