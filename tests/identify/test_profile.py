"""Profiles: linear and curved problems with known ends, and every kind that there is."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from box_scene import CONDUCTIVITY, edit, write_block
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.identify import Model, profile
from thermo.identify._path import LEVEL
from thermo.inverse import LogModel, Meshing, Stepping, log_model

pytestmark = pytest.mark.usefixtures("bricks")

Array = np.ndarray


def box(*sizes: float) -> Array:
    """Bounds on both sides of zero."""
    return np.array([[-size, size] for size in sizes])


def linear(seed: int, unknowns: int = 3) -> tuple[Model, Array, Array]:
    """A linear problem, its optimum, and the standard deviations there."""
    random = np.random.default_rng(seed)
    matrix = random.standard_normal((30, unknowns)) * [5.0, 1.0, 20.0][:unknowns]
    data = random.standard_normal(30)
    best = np.linalg.lstsq(matrix, data, rcond=None)[0]
    deviation = np.sqrt(np.diagonal(np.linalg.inv(matrix.T @ matrix)))
    return (lambda u: (matrix @ u - data, matrix)), best, deviation


def of(*terms: Callable[[Array], Array]) -> Model:
    """Residuals of unknowns, with derivatives by complex steps."""

    def model(unknowns: Array) -> tuple[Array, Array]:
        steps = 1e-30j * np.eye(len(unknowns))
        value = [term(unknowns) for term in terms]
        slopes = [[term(unknowns + step).imag / 1e-30 for step in steps] for term in terms]
        return np.array(value), np.array(slopes)

    return model


@given(seed=st.integers(0, 999), number=st.integers(0, 2))
@settings(max_examples=20, deadline=None)
def test_a_linear_problem_has_the_linear_interval(seed: int, number: int) -> None:
    model, best, deviation = linear(seed)
    found = profile(model, np.zeros(3), number)
    half = np.sqrt(LEVEL) * deviation[number]
    assert found.kind == "bounded" and not found.nonlinear()
    assert found.best == pytest.approx(best, abs=0.02 * deviation.min())
    assert found.lower == pytest.approx(best[number] - half, abs=0.005 * half)
    assert found.upper == pytest.approx(best[number] + half, abs=0.005 * half)
    assert found.linear == pytest.approx(half, rel=1e-6)
    steps = np.diff(found.rises[found.values >= found.values[np.argmin(found.rises)]])
    assert steps == pytest.approx(np.full(len(steps), LEVEL / 6), rel=0.05), "equal rises"


def test_a_curved_problem_has_the_ends_of_its_own() -> None:
    # chi^2 = (2 (e^a - 1))^2: a = ln(1 +- sqrt(level) / 2), the lower end at ln(0.02).
    model = of(lambda u: 2 * (np.exp(u[0]) - 1))
    found = profile(model, np.array([0.3]), 0)
    half = np.sqrt(LEVEL) / 2
    assert found.kind == "bounded" and found.nonlinear()
    assert found.upper == pytest.approx(np.log(1 + half), rel=0.02)
    assert found.lower == pytest.approx(np.log(1 - half), rel=0.02)


def test_one_side_may_have_no_end() -> None:
    found = profile(of(lambda u: 1.5 * (np.exp(u[0]) - 1)), np.array([0.1]), 0)
    assert found.kind == "one-sided" and found.lower is None
    assert found.upper == pytest.approx(np.log(1 + np.sqrt(LEVEL) / 1.5), rel=0.02)


def test_what_another_makes_up_for_is_flat() -> None:
    model = of(lambda u: 50 * (u[0] + u[1] - 1))
    found = profile(model, np.array([0.5, 0.2]), 0, bounds=box(5.0, 9.0))
    assert found.kind == "flat" and found.lower is None and found.upper is None
    assert found.values.min() == pytest.approx(-5.0) and found.values.max() == pytest.approx(5.0)
    assert found.rises.max() < 1e-6


@pytest.mark.parametrize("far", [5e2, 5e4, 5e7])
def test_one_that_hardly_matters_and_is_far_off_does_not_hold_up_the_others(far: float) -> None:
    # Uncut, the step of the second is `far`; cut as a whole it would leave the first where it is.
    model = of(lambda u: 50 * (u[0] - 1), lambda u: 5 / far * (u[1] - far))
    found = profile(model, np.zeros(2), 0, bounds=np.array([[-5.0, 5.0], [-20.0, 20.0]]))
    half = np.sqrt(LEVEL) / 50
    assert found.best[0] == pytest.approx(1.0, abs=1e-3 * half) and found.kind == "bounded"
    assert (found.lower, found.upper) == (pytest.approx(1 - half), pytest.approx(1 + half))


def test_a_plateau_is_left_by_what_values_promise_not_their_logarithms() -> None:
    # At e^-12 nothing of e^u is felt; the data want e^u = 3.
    model = of(lambda u: 40 * (np.exp(u[0]) - 3), lambda u: 2 * u[1])
    found = profile(model, np.array([-12.0, 0.5]), 1, bounds=box(20.0, 20.0))
    assert found.kind == "bounded" and found.best == pytest.approx([np.log(3), 0.0], abs=1e-3)


def test_a_bent_valley_is_followed_to_its_end() -> None:
    # Rosenbrock's, 25 times as narrow as it is long.
    model = of(lambda u: 100 * (u[1] - u[0] ** 2), lambda u: 4 * (u[0] - 1))
    found = profile(model, np.array([-1.2, 1.0]), 0)
    assert found.kind == "bounded" and found.best == pytest.approx([1.0, 1.0], abs=0.01)
    half = np.sqrt(LEVEL) / 4
    assert (found.lower, found.upper) == (pytest.approx(1 - half), pytest.approx(1 + half))


def test_where_nothing_is_told_within_the_bounds_the_best_on_one_of_them_is_chance() -> None:
    found = profile(
        of(lambda u: 0.3 * (u[0] - 4), lambda u: u[1]), np.zeros(2), 0, bounds=box(1.0, 1.0)
    )
    assert found.best[0] == 1.0 and found.rises.max() < LEVEL
    assert found.kind == "flat"


def test_bounds_may_be_a_list_and_what_is_no_pair_each_is_refused() -> None:
    model = of(lambda u: u[0] - 1, lambda u: u[1] - 3)
    found = profile(model, np.array([0.0, 0.3]), 0, bounds=[[-5, 1], [-2, 2]])
    assert found.kind == "at bound"
    with pytest.raises(InputError, match="not those of the unknowns"):
        profile(model, np.zeros(2), 0, bounds=[[-5, 1]])


def test_an_optimum_beyond_a_bound_lies_on_it() -> None:
    model = of(lambda u: u[0] - 1, lambda u: u[1] - 3)
    # The optimum of the other, 3, is out of reach as well.
    bounds = np.array([[-5.0, 1.0], [-2.0, 2.0]])
    found = profile(model, np.array([0.0, 0.3]), 0, bounds=bounds)
    assert found.kind == "at bound" and found.upper is None
    assert found.lower == pytest.approx(1.0 - np.sqrt(LEVEL), rel=0.005)
    assert found.best == pytest.approx([1.0, 2.0])


def test_another_at_its_bound_no_longer_makes_up() -> None:
    # Below a = 0.11 the other would pass its bound 2: chi^2 = 9 a^2 + 1 there, 0.9 (a + 1)^2 above.
    model = of(lambda u: 3 * (u[0] + u[1] - 2), lambda u: u[1] - 3)
    bounds = np.array([[-5.0, 5.0], [-2.0, 2.0]])
    found = profile(model, np.array([0.5, 1.0]), 0, bounds=bounds)
    assert found.kind == "bounded" and found.best == pytest.approx([0.0, 2.0], abs=0.02)
    assert found.lower == pytest.approx(-np.sqrt(LEVEL) / 3, rel=0.01)
    assert found.upper == pytest.approx(np.sqrt((1 + LEVEL) / 0.9) - 1, rel=0.01)


def test_a_second_valley_is_seen_and_a_deeper_one_becomes_the_first() -> None:
    # Valleys near -1 and 1; the tilt makes the one at -1 the deeper one.
    tilted = of(lambda u: u[0] ** 2 - 1, lambda u: 0.4 * (u[0] + 1))
    found = profile(tilted, np.array([1.0]), 0)
    assert found.best[0] == pytest.approx(-1.0, abs=0.01)
    assert found.kind == "multimodal"


def test_a_search_that_stalls_is_called_failed() -> None:
    def stubborn(unknowns: Array) -> tuple[Array, Array]:
        # A Jacobian of the wrong sign points uphill for ever.
        residual = np.array([unknowns[0], 3.0 * (unknowns[1] - 2.0)])
        return residual, np.array([[1.0, 0.0], [0.0, -3.0]])

    assert profile(stubborn, np.array([0.0, 0.0]), 0).kind == "failed"


def test_a_lamp_bounds_a_conductivity_and_cooling_alone_does_not(tmp_path: Path) -> None:
    block = write_block(tmp_path / "block")
    # A lamp of a nanowatt leaves cooling alone, and lets both runs share their programs.
    runs = json.loads((block / "scene.json").read_text())["runs"]
    runs["cooling"]["heater"] = {**runs["lamp"]["heater"], "power": 1e-9}
    edit(block, runs=runs)

    def model(run: str) -> LogModel:
        return log_model(
            block, runs=(run,), unknown=("conductivity", "volumetric_heat_capacity", "convection"),
            initial={"conductivity": CONDUCTIVITY},
            meshing=Meshing(order=1, max_nodes=600, corrected=False, cache=tmp_path / "meshes"),
            stepping=Stepping(tolerance=0.1, rtol=1e-9), model_error=0.1,
        )  # fmt: skip

    lamp = model("lamp")
    found = profile(lamp, lamp.first, 0, bounds=lamp.bounds)
    assert found.kind == "bounded" and not found.nonlinear()
    both = model("cooling")
    near = both.first[:, None] + box(1.0, 2.0, 2.0)
    free = profile(both, both.first, 0, bounds=near)
    assert free.kind == "flat" and free.rises.max() < 0.1
    assert np.ptp(free.values) == pytest.approx(2.0), "from bound to bound"


def test_an_unknown_that_is_not_there_is_refused() -> None:
    with pytest.raises(InputError) as caught:
        profile(lambda at: (at, np.eye(2)), np.zeros(2), 2)
    assert caught.value.where == "number" and caught.value.limit == "0 to 1"
