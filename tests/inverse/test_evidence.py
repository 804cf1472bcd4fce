"""The smoothness that data choose: closed form, known truth, no data."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.inverse._evidence import LEAST_STEP, Linearised, likely_steps, most_probable_steps

CONTROLS, VALUES = 40, 400
PAIRS = np.diff(np.eye(CONTROLS), axis=0)


def problem(field: np.ndarray, *, noise: float, seed: int = 0, belief: float = 0.0) -> Linearised:
    """A chain of controls seen through a random blur, where the fit stands at zero.

    `belief`: precision of a prior on each control about zero.
    """
    random = np.random.default_rng(seed)
    blur = random.standard_normal((VALUES, CONTROLS)) / noise
    data = blur @ field + random.standard_normal(VALUES)
    return Linearised(
        blur.T @ blur + belief * np.eye(CONTROLS), -blur.T @ data,
        {"k": PAIRS}, {"k": np.zeros(len(PAIRS))},
    )  # fmt: skip


def walk(step: float, seed: int) -> np.ndarray:
    return np.cumsum(step * np.random.default_rng(seed).standard_normal(CONTROLS))


def test_differences_of_the_evidence_are_those_of_the_marginal_density() -> None:
    random = np.random.default_rng(3)
    blur, belief = random.standard_normal((60, CONTROLS)), 0.5
    data = blur @ walk(0.3, 5) + random.standard_normal(60)
    near = Linearised(
        blur.T @ blur + belief * np.eye(CONTROLS), -blur.T @ data,
        {"k": PAIRS}, {"k": np.zeros(len(PAIRS))},
    )  # fmt: skip

    def marginal(step: float) -> float:
        """ln N(data; 0, I + B P^-1 B'), with the improper part of the prior's constant."""
        precision = PAIRS.T @ PAIRS / step**2 + belief * np.eye(CONTROLS)
        spread = np.eye(60) + blur @ np.linalg.solve(precision, blur.T)
        _, size = np.linalg.slogdet(spread)
        _, own = np.linalg.slogdet(precision)
        # The evidence counts rank(D) ln s for the smoothness, where a proper prior has its own
        # determinant; both differ by what is written here.
        counted = -len(PAIRS) * np.log(step) - 0.5 * own
        return -0.5 * data @ np.linalg.solve(spread, data) - 0.5 * size + counted

    steps = (0.01, 0.1, 0.3, 2.0)
    mine = np.array([near.log_evidence({"k": step}) for step in steps])
    true = np.array([marginal(step) for step in steps])
    assert np.allclose(mine - mine[0], true - true[0], rtol=1e-6, atol=1e-4)


@pytest.mark.parametrize("step", [0.03, 0.3])
def test_the_step_of_a_random_field_is_found(step: float) -> None:
    found = [
        most_probable_steps(problem(walk(step, seed), noise=0.05, seed=seed))["k"]
        for seed in range(20)
    ]
    # 39 differences know their own spread to 11 %; the tried steps are 28 % apart.
    assert np.exp(np.mean(np.log(found))) == pytest.approx(step, rel=0.15)
    assert np.std(np.log(found)) < 0.35


def test_a_uniform_field_is_called_uniform() -> None:
    for seed in range(10):
        near = problem(np.full(CONTROLS, 0.7), noise=0.3, seed=seed)
        steps = most_probable_steps(near)
        move, curvature = near.solve(steps)
        # Seen one by one, controls would scatter by 0.3 / sqrt(400).
        assert np.ptp(move) < 0.03
        # And its mean is known as well as that of one value.
        sd = np.sqrt(np.linalg.inv(curvature).mean())
        assert abs(move.mean() - 0.7) < 4 * sd and sd < 0.015


def test_noise_is_seldom_very_strong_evidence_of_a_field_that_varies() -> None:
    flat = np.full(CONTROLS, 0.7)
    found = [
        most_probable_steps(problem(flat, noise=0.3, seed=seed))["k"] > LEAST_STEP
        for seed in range(200)
    ]
    # Twice the gain passes 10 with a probability of about 0.0008.
    assert sum(found) <= 1


def test_a_variation_that_the_noise_could_feign_is_not_claimed() -> None:
    field = walk(0.004, 3)
    near = problem(field, noise=0.15, seed=3)
    likely = [near.log_evidence({"k": step}) for step in (LEAST_STEP, 0.004)]
    assert 0 < 2 * (likely[1] - likely[0]) < 10
    assert most_probable_steps(near)["k"] == LEAST_STEP
    clear = problem(field, noise=0.05, seed=3)
    assert most_probable_steps(clear)["k"] > LEAST_STEP


def test_each_field_has_a_step_of_its_own() -> None:
    rough, flat = walk(0.4, 1), np.zeros(CONTROLS)
    one, other = problem(rough, noise=0.05, seed=1), problem(flat, noise=0.05, seed=2)
    empty = np.zeros((CONTROLS, CONTROLS))
    none = np.zeros_like(PAIRS)
    both = Linearised(
        np.block([[one.information, empty], [empty, other.information]]),
        np.concatenate([one.slope, other.slope]),
        {"rough": np.hstack([PAIRS, none]), "flat": np.hstack([none, PAIRS])},
        {"rough": np.zeros(len(PAIRS)), "flat": np.zeros(len(PAIRS))},
    )
    steps = most_probable_steps(both)
    assert steps["rough"] == pytest.approx(most_probable_steps(one)["k"], rel=1e-9)
    assert steps["flat"] < 0.05 < 0.2 < steps["rough"]


def test_a_field_without_neighbours_and_data_without_knowledge_are_no_trouble() -> None:
    lonely = Linearised(np.eye(1), np.array([-2.0]), {"k": np.zeros((0, 1))}, {"k": np.zeros(0)})
    move, _ = lonely.solve(most_probable_steps(lonely))
    assert move == pytest.approx([2.0])
    blind = Linearised(
        np.zeros((CONTROLS, CONTROLS)), np.zeros(CONTROLS), {"k": PAIRS}, {"k": PAIRS @ walk(1, 0)}
    )
    steps = most_probable_steps(blind)
    assert np.isfinite(list(steps.values())).all() and steps["k"] >= LEAST_STEP
    move, _ = blind.solve(steps)
    assert np.allclose(PAIRS @ move, -blind.apart["k"], atol=1e-6)


@pytest.mark.parametrize("step", [0.03, 0.3])
def test_likely_steps_hold_the_true_one_and_sum_to_one(step: float) -> None:
    found = likely_steps(problem(walk(step, 1), noise=0.1))
    weights = np.array([weight for _, weight in found])
    steps = np.array([one["k"] for one, _ in found])
    assert weights.sum() == pytest.approx(1.0) and len(found) > 1
    mean = weights @ np.log(steps)
    assert abs(mean - np.log(step)) < 3 * np.sqrt(weights @ (np.log(steps) - mean) ** 2) + 0.25


def test_one_value_leaves_small_steps_alike() -> None:
    found = likely_steps(problem(np.zeros(CONTROLS), noise=0.1))
    assert min(one["k"] for one, _ in found) == LEAST_STEP
    assert max(one["k"] for one, _ in found) < 0.2


def test_steps_of_several_fields_are_weighed_together() -> None:
    rough, even = problem(walk(0.3, 1), noise=0.1), problem(np.zeros(CONTROLS), noise=0.1)
    none = np.zeros_like(PAIRS)
    both = Linearised(
        np.block([
            [rough.information, np.zeros_like(rough.information)],
            [np.zeros_like(rough.information), even.information],
        ]),
        np.concatenate([rough.slope, even.slope]),
        {"rough": np.hstack([PAIRS, none]), "even": np.hstack([none, PAIRS])},
        {"rough": np.zeros(len(PAIRS)), "even": np.zeros(len(PAIRS))},
    )  # fmt: skip
    found = likely_steps(both)
    mean = {
        name: np.exp(sum(weight * np.log(one[name]) for one, weight in found))
        for name in ("rough", "even")
    }
    assert mean["rough"] == pytest.approx(0.3, rel=0.5) and mean["even"] < 0.03
    assert len(found) < len({one["rough"] for one, _ in found}) * 33
