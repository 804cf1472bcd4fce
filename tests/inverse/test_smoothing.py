"""Smoothness and weights from the data: noise that is what it says, and noise that is not."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.inverse._objective import Objective, residual, start
from thermo.inverse._reading_errors import colour
from thermo.inverse._smoothing import ALL_BUT_UNIFORM, ask_data, much_the_same, with_choice
from thermo.observe import Scene

from .objectives import case, measured

RUNS = ("lamp", "cooling")


@pytest.fixture(scope="module")
def objective(scene: Scene) -> Objective:
    return replace(measured([case(scene.runs[name]) for name in RUNS]), sequence=(0, 1))


@pytest.fixture(scope="module")
def samples(scene: Scene) -> list[np.ndarray]:
    return [scene.runs[name].recording.points for name in RUNS]


def with_noise(objective: Objective, noise: list[np.ndarray]) -> Objective:
    """The same runs, measured as simulated here, with a whitened residual of `noise`."""
    value = np.asarray(eqx.filter_jit(residual)(objective, start(objective)))
    (group,) = objective.cases
    apart = value[: group.data.size].reshape(group.data.shape)
    more = apart - jnp.asarray(np.stack(noise))
    data = group.data + jax.vmap(colour)(group.errors, group.used, more)
    return replace(objective, cases=(replace(group, data=data),))


def white(objective: Objective, seed: int) -> np.ndarray:
    shape = objective.cases[0].data.shape[1:]
    return np.random.default_rng(seed).standard_normal(shape)


def chosen_by_data(objective: Objective, samples: list[np.ndarray]) -> Objective:
    return with_choice(objective, ask_data(objective, samples))


def lighter(before: Objective, after: Objective) -> np.ndarray:
    """By what factor the weight of each run fell [1]."""
    old, new = (np.asarray(one.cases[0].trust) for one in (before, after))
    return old / new


def test_noise_as_stated_leaves_the_weights(
    objective: Objective, samples: list[np.ndarray]
) -> None:
    noisy = with_noise(objective, [white(objective, 0), white(objective, 1)])
    chosen = chosen_by_data(noisy, samples)
    assert np.all(lighter(noisy, chosen) >= 1.0) and np.all(lighter(noisy, chosen) < 1.15)


def test_a_pattern_weighs_as_one_frame_and_only_in_its_own_run(
    objective: Objective, samples: list[np.ndarray]
) -> None:
    frames = objective.cases[0].data.shape[1]
    pattern = np.tile(white(objective, 2)[:1], (frames, 1))
    noisy = with_noise(objective, [white(objective, 0), pattern])
    first, second = lighter(noisy, chosen_by_data(noisy, samples))
    assert first < 1.15
    # The field takes up a part of the pattern, and thirty samples know its size to an eighth.
    assert 0.5 * np.sqrt(frames) < second < 1.3 * np.sqrt(frames)


def test_noise_larger_than_stated_weighs_less(
    objective: Objective, samples: list[np.ndarray]
) -> None:
    loud = [3 * white(objective, 0), white(objective, 1)]
    noisy = with_noise(objective, loud)
    first, second = lighter(noisy, chosen_by_data(noisy, samples))
    assert first == pytest.approx(3.0, rel=0.1) and second < 1.15


def test_the_tangents_get_the_same_choice(objective: Objective, samples: list[np.ndarray]) -> None:
    both = replace(objective, tangents=objective)
    chosen = chosen_by_data(both, samples)
    assert chosen.tangents is not None
    for name, prior in chosen.priors.items():
        assert float(prior.step) == float(chosen.tangents.priors[name].step)
    assert np.array_equal(chosen.cases[0].trust, chosen.tangents.cases[0].trust)


def test_what_is_called_the_same(objective: Objective) -> None:
    def other(step: float, weight: float) -> Objective:
        priors = {n: replace(p, step=jnp.asarray(step)) for n, p in objective.priors.items()}
        cases = tuple(replace(c, trust=c.trust * weight) for c in objective.cases)
        return replace(objective, priors=priors, cases=cases)

    base = other(0.1, 1.0)
    assert much_the_same(base, base)
    assert much_the_same(base, other(0.15, 0.8)) and much_the_same(other(0.15, 0.8), base)
    assert not much_the_same(base, other(0.3, 1.0))
    assert not much_the_same(base, other(0.1, 0.5))
    assert much_the_same(other(ALL_BUT_UNIFORM, 1.0), other(1e-3, 1.0)), "both are uniform"
