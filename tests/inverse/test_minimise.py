"""The loop of a fit: every optimiser, interruption and resumption, best so far, stages."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree

from thermo.errors import InputError
from thermo.inverse import (
    AbstractOptimiser,
    Adam,
    GaussNewtonKrylov,
    LevenbergMarquardt,
    LimitedMemoryBfgs,
    load_checkpoint,
)
from thermo.inverse._first_order import loss
from thermo.inverse._minimise import _about, minimise
from thermo.inverse._objective import Objective, start

from .objectives import at, beliefs
from .walk import Walk

TIGHT = {
    "lm": LevenbergMarquardt(max_steps=30, rtol=1e-8),
    "gauss_newton": GaussNewtonKrylov(max_steps=30, rtol=1e-8),
    "lbfgs": LimitedMemoryBfgs(max_steps=80, rtol=1e-8),
}
ALL: dict[str, AbstractOptimiser] = {**TIGHT, "adam": Adam(max_steps=8, rate=0.2)}


@pytest.fixture(scope="module")
def problem() -> Objective:
    return beliefs()


def flat(parameters: Any) -> np.ndarray:
    return np.concatenate([np.ravel(leaf) for leaf in jax.tree.leaves(parameters)])


@pytest.fixture(scope="module")
def minimum(problem: Objective) -> np.ndarray:
    """By Newton's method on the loss itself, without any of the optimisers."""
    point, unravel = ravel_pytree(start(problem))
    value = jax.jit(lambda p: loss(problem, unravel(p)))
    for _ in range(30):
        point = point - jnp.linalg.solve(jax.hessian(value)(point), jax.grad(value)(point))
    assert np.abs(np.asarray(jax.grad(value)(point))).max() < 1e-9
    return np.asarray(point)


@pytest.mark.parametrize("name", list(TIGHT))
def test_second_order_methods_end_at_the_same_minimum(
    name: str, problem: Objective, minimum: np.ndarray
) -> None:
    told: list[tuple[int, int | None, float]] = []
    optimiser = TIGHT[name]
    fit = minimise([at(problem)], optimiser, key="x", on_step=lambda *args: told.append(args))
    assert fit.success
    (history,) = fit.history
    assert len(history) < optimiser.max_steps
    # A fit settles where a step gains less than a fraction of one unit of log-likelihood.
    assert np.allclose(flat(fit.parameters), minimum, rtol=0, atol=2e-2)
    assert fit.loss == min(history) < 0.02 * history[0]
    assert history[0] == pytest.approx(float(loss(problem, start(problem))), rel=1e-12)
    # Everyone who watches is told of every step.
    assert [value for _, _, value in told] == history
    assert [number for number, _, _ in told] == list(range(1, len(history) + 1))


def test_adam_makes_all_its_steps_downhill(problem: Objective) -> None:
    fit = minimise([at(problem)], ALL["adam"], key="x")
    (history,) = fit.history
    assert fit.success and len(history) == 8
    assert np.all(np.diff(history)[:6] < 0) and fit.loss < 0.1 * history[0]
    # Adam reports the loss where it left; what it gives back belongs to the loss it reports.
    assert fit.loss == pytest.approx(float(loss(problem, fit.parameters)), rel=1e-12)


def test_adam_has_a_rate_for_each_field(problem: Objective) -> None:
    still = Adam(max_steps=2, rate=0.1, rates={"convection": 1e-9})
    fit = minimise([at(problem)], still, key="x")
    first = start(problem)
    moved = {name: np.abs(np.asarray(fit.parameters[name] - first[name])).max() for name in first}
    assert moved["conductivity"] == pytest.approx(0.1, rel=0.01)
    assert 0 < moved["convection"] < 2e-9


@pytest.mark.parametrize("name", ["lm", "lbfgs", "adam", "gauss_newton"])
def test_a_resumed_fit_runs_through_the_same_losses(
    name: str, problem: Objective, tmp_path: Path
) -> None:
    optimiser = ALL[name]
    whole = minimise([at(problem)], optimiser, key="x")
    file = tmp_path / "checkpoint.npz"

    def stop(number: int, most: int, value: float) -> None:
        if number == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        minimise([at(problem)], optimiser, key="x", checkpoint=file, on_step=stop)
    saved = load_checkpoint(file, "x")
    assert saved is not None and len(saved.history[0]) == 2
    assert saved.best_loss == min(saved.history[0])
    resumed = minimise([at(problem)], optimiser, key="x", checkpoint=file)
    assert np.allclose(resumed.history[0], whole.history[0], rtol=1e-12, atol=0)
    assert len(resumed.history[0]) == len(whole.history[0])
    assert np.allclose(flat(resumed.parameters), flat(whole.parameters), rtol=0, atol=1e-12)
    # It stays until the result is safe, and a fit that is called again then ends as it did.
    assert list(tmp_path.iterdir()) == [file]
    again = minimise([at(problem)], optimiser, key="x", checkpoint=file)
    assert again.loss <= resumed.loss * (1 + 1e-12)
    assert np.allclose(flat(again.parameters), flat(whole.parameters), rtol=0, atol=2e-2)


def test_a_checkpoint_of_another_fit_is_refused(problem: Objective, tmp_path: Path) -> None:
    file = tmp_path / "checkpoint.npz"

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        minimise([at(problem)], ALL["adam"], key="one", checkpoint=file, on_step=stop)
    before = file.read_bytes()
    with pytest.raises(InputError) as caught:
        minimise([at(problem)], ALL["adam"], key="two", checkpoint=file)
    assert caught.value.where == str(file)
    assert caught.value.value == "one"
    assert caught.value.limit == "two, the same data and settings as the fit that was interrupted"
    assert "delete" in caught.value.remedy or "out" in caught.value.remedy
    assert file.read_bytes() == before


def test_a_later_stage_begins_where_the_earlier_one_ended(
    problem: Objective, minimum: np.ndarray
) -> None:
    other = beliefs(centre=0.4)
    optimiser = TIGHT["gauss_newton"]
    fit = minimise([at(problem), at(other)], optimiser, key="x")
    first = minimise([at(problem)], optimiser, key="x")
    assert len(fit.history) == 2 and fit.history[0] == first.history[0]
    assert fit.history[1][0] == pytest.approx(float(loss(other, first.parameters)), rel=1e-12)
    assert not np.allclose(flat(fit.parameters), minimum, atol=0.1)


def test_interrupted_in_the_second_stage_the_first_is_not_repeated(
    problem: Objective, tmp_path: Path
) -> None:
    other = beliefs(centre=0.4)
    whole = minimise([at(problem), at(other)], ALL["adam"], key="x")
    file, seen = tmp_path / "checkpoint.npz", [0]

    def stop(number: int, most: int, value: float) -> None:
        seen[0] += 1
        if seen[0] == 8 + 2:
            raise KeyboardInterrupt

    stages = [at(problem), at(other)]
    with pytest.raises(KeyboardInterrupt):
        minimise(stages, ALL["adam"], key="x", checkpoint=file, on_step=stop)
    told: list[int] = []
    resumed = minimise(
        stages, ALL["adam"], key="x", checkpoint=file, on_step=lambda n, *_: told.append(n)
    )
    assert told == [11, 12, 13, 14, 15, 16]
    assert np.allclose(resumed.history, whole.history, rtol=1e-12, atol=0)


def test_the_best_step_is_kept_and_running_out_of_steps_is_no_success(problem: Objective) -> None:
    walk = Walk(max_steps=4, losses=(9.0, 0.25, 4.0, 1.0), fixed=False)
    fit = minimise([at(problem)], walk, key="x")
    assert fit.history == [[9.0, 0.25, 4.0, 1.0]]
    assert fit.loss == 0.25 and not fit.success
    assert np.allclose(flat(fit.parameters), flat(start(problem)) + 0.2)


def test_steps_to_come_are_told_by_the_stages_that_ended() -> None:
    settles, fixed = LevenbergMarquardt(), Adam(max_steps=50)
    assert _about(fixed, [3], 2) == _about(fixed, [50, 1], 2) == 100
    assert _about(settles, [4], 3) is None
    assert _about(settles, [5, 2], 3) == 15
    assert _about(settles, [5, 7], 3) == 17
    assert _about(settles, [5, 7, 2], 3) == 19
