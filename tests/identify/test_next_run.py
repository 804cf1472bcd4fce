"""The next run: closed forms, the weakest direction, two unknowns to be told apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.identify import next_runs
from thermo.inverse import Sensitivity

NAMES = ("conductivity", "convection", "emissivity")
PRIOR = dict.fromkeys(NAMES, 1.0)
FRAMES, SAMPLES, NOISE = 5, 8, 0.1


def run(*columns: float, seed: int = 0, name: str = "a") -> Sensitivity:
    """A run that shows the unknowns by so much, each in its own pattern [K]."""
    pattern = np.random.default_rng(seed).standard_normal((FRAMES, SAMPLES, 3))
    return Sensitivity(
        NAMES, {name: pattern * np.array(columns)}, {name: NOISE}, values=(1.0, 10.0, 0.5)
    )


def covariance(*runs: Sensitivity) -> np.ndarray:
    precision = np.eye(3)
    for one in runs:
        for slopes in one.slopes.values():
            matrix = slopes.reshape(-1, 3) / NOISE
            precision += matrix.T @ matrix
    return np.linalg.inv(precision)


NOW = run(1.0, 1.0, 0.02)
CANDIDATES = {
    "again": run(1.0, 1.0, 0.02, seed=1),
    "radiates": run(0.1, 0.1, 0.5, seed=2),
    "bright": run(4.0, 4.0, 0.02, seed=3),
}


def test_what_is_left_is_that_of_a_fit_of_all_runs() -> None:
    for one in next_runs(NOW, CANDIDATES, prior=PRIOR, model_error=0.0):
        before, after = covariance(NOW), covariance(NOW, CANDIDATES[one.name])
        gain = 0.5 * np.log(np.linalg.det(before) / np.linalg.det(after))
        assert one.gain == pytest.approx(gain, rel=1e-6)
        assert one.mean == pytest.approx(np.sqrt(np.trace(after) / 3), rel=1e-6)
        assert one.pair is None


def test_the_weakest_direction_decides_and_not_the_most_information() -> None:
    found = next_runs(NOW, CANDIDATES, prior=PRIOR, model_error=0.0)
    assert found[0].name == "radiates"
    alone = np.sqrt(covariance(NOW, CANDIDATES["radiates"])[2, 2])
    assert found[0].weakest == pytest.approx(alone, rel=0.05)
    assert found[0].before == pytest.approx(np.sqrt(covariance(NOW)[2, 2]), rel=0.05)
    assert found[0].weakest < 0.3 * found[1].weakest


def test_two_unknowns_that_look_alike_are_split_by_the_run_in_which_they_do_not() -> None:
    now = run(1.0, 1.0, 1.0)
    now.slopes["a"][..., 1] = 2 * now.slopes["a"][..., 0]
    alike = run(5.0, 5.0, 5.0, seed=1)
    alike.slopes["a"][..., 1] = 2 * alike.slopes["a"][..., 0]
    candidates = {"louder": alike, "other": run(0.3, 0.3, 0.3, seed=2)}
    split = ("convection", "conductivity")
    found = next_runs(now, candidates, split=split, prior=PRIOR, model_error=0.0)
    assert [one.name for one in found] == ["other", "louder"]
    after = covariance(now, candidates["other"])[:2, :2]
    assert found[0].pair == pytest.approx(np.sqrt(np.linalg.eigvalsh(after)[-1]), rel=1e-6)
    assert found[1].pair is not None and found[1].pair > 0.4, "the ratio stays the prior's"


@pytest.mark.parametrize(
    "more",
    [
        Sensitivity(NAMES[:2], {"a": np.zeros((5, 8, 2))}, {"a": 0.1}, values=(1.0, 10.0)),
        replace(NOW, values=(2.0, 10.0, 0.5)),
    ],
)
def test_a_candidate_with_other_unknowns_is_refused(more: Sensitivity) -> None:
    with pytest.raises(InputError) as caught:
        next_runs(NOW, {"odd": more})
    assert caught.value.where == "candidates.odd"


@pytest.mark.parametrize("split", [("conductivity", "density"), ("convection", "convection")])
def test_a_pair_that_is_none_is_refused(split: tuple[str, str]) -> None:
    with pytest.raises(InputError) as caught:
        next_runs(NOW, CANDIDATES, split=split)
    assert caught.value.where == "split"
