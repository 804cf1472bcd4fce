"""Means over regions: against closed forms, a constrained minimum, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from posteriors import COUNT, MESH, SIZE, left, smoothness
from scipy.optimize import minimize

from thermo.errors import InputError
from thermo.identify import region_mean, region_profile
from thermo.identify._path import LEVEL
from thermo.inverse import FieldLoss, FieldPosterior
from thermo.mesh import face_areas, face_centres

Array = np.ndarray
NAME = "convection"
ABOVE = face_centres(MESH)[:, 2] > 0.02


def with_loss(
    sd: float, of: Callable[[Array], tuple[float, Array]] | None = None, first: float = 0.0
) -> FieldPosterior:
    """Controls that are known to `sd` each by themselves, unless their loss is another one."""
    plain = of or (lambda d: (float(d @ d) / sd**2, d / sd**2))
    own = FieldLoss(plain, np.full(SIZE, first), np.eye(SIZE) / sd**2)
    return replace(left(smoothness(sd)), loss=own)


def logarithm(found: FieldPosterior, departures: Array, inside: Array) -> float:
    """Of the mean over a region, written down once more."""
    values = 2.0 * np.exp(found.onto_faces(NAME)[inside] @ departures[found.part(NAME)])
    return float(np.log(np.average(values, weights=face_areas(MESH)[inside])))


@pytest.mark.parametrize("inside", [ABOVE, np.arange(len(ABOVE)) == 3, np.ones_like(ABOVE)])
def test_a_linear_case_has_the_linear_interval(inside: Array) -> None:
    random = np.random.default_rng(0)
    rows = 3000 * (np.eye(SIZE) + 0.3 * random.standard_normal((SIZE, SIZE)))
    data = random.standard_normal(SIZE)
    square, best = rows.T @ rows, np.linalg.solve(rows, data)

    def of(departures: Array) -> tuple[float, Array]:
        apart = rows @ departures - data
        return float(apart @ apart), rows.T @ apart

    plain = with_loss(0.01, of, first=0.001)
    found = replace(plain, loss=FieldLoss(of, np.full(SIZE, 0.001), square))
    made = region_profile(found, NAME, inside)
    steps = 1e-6 * np.eye(SIZE)
    slope = [logarithm(found, best + h, inside) - logarithm(found, best - h, inside) for h in steps]
    slope = np.array(slope) / 2e-6
    half = np.sqrt(LEVEL * slope @ np.linalg.solve(square, slope))
    assert made.kind == "bounded" and not made.nonlinear()
    middle = logarithm(found, best, inside)
    assert made.lower == pytest.approx(middle - half, abs=0.005 * half)
    assert made.upper == pytest.approx(middle + half, abs=0.005 * half)
    assert made.linear == pytest.approx(half, rel=0.005)


def test_ends_are_those_of_a_constrained_search_where_the_mean_is_curved() -> None:
    found = with_loss(0.8)
    made = region_profile(found, NAME, ABOVE)
    assert made.kind == "bounded" and made.remainders.max() < 0.01
    rim = {"type": "ineq", "fun": lambda d: LEVEL - float(d @ d) / 0.8**2}
    for way, end in ((1, made.lower), (-1, made.upper)):
        sought = minimize(
            lambda d, way=way: way * logarithm(found, d, ABOVE), np.full(SIZE, -0.2 * way),
            constraints=[rim], options={"maxiter": 400},
        )  # fmt: skip
        assert end == pytest.approx(way * sought.fun, abs=0.01 * made.linear)


def test_a_profile_that_is_not_the_linear_one_is_flagged() -> None:
    def of(departures: Array) -> tuple[float, Array]:
        # As of readings that rise with the logarithm the more the larger it is.
        read = np.expm1(departures)
        return float(read @ read) / 0.5**2, read * np.exp(departures) / 0.5**2

    made = region_profile(with_loss(0.5, of), NAME, ABOVE)
    assert made.kind == "bounded" and made.nonlinear()
    assert made.upper is not None and made.lower is not None
    middle = np.log(2.0)
    assert made.upper - middle < 0.9 * made.linear and middle - made.lower > 1.5 * made.linear


def test_what_the_runs_do_not_see_is_flat() -> None:
    made = region_profile(with_loss(3.0, lambda d: (0.0, np.zeros(SIZE))), NAME, ABOVE)
    assert made.kind == "flat" and made.lower is None and made.upper is None


def test_the_linear_interval_is_of_the_whole_posterior() -> None:
    found = left(smoothness(0.1, weight=0.5), smoothness(0.3, weight=0.5), shift=0.05)
    mean = region_mean(found, NAME, "above", ABOVE)
    onto = np.average(found.onto_faces(NAME)[ABOVE], axis=0, weights=face_areas(MESH)[ABOVE])
    variance = (0.5 * 0.1**2 + 0.5 * 0.3**2) * np.sum(onto**2) + 0.05**2
    assert mean.value == pytest.approx(2.0) and mean.deviation == pytest.approx(np.sqrt(variance))
    assert mean.share == pytest.approx(face_areas(MESH)[ABOVE].sum() / face_areas(MESH).sum())
    assert mean.region == "above" and mean.profile is None and len(onto) == COUNT


def test_a_field_that_is_not_there_and_a_place_of_nothing_are_refused() -> None:
    for name, inside, where in (("heat", ABOVE, "name"), (NAME, ABOVE & False, "inside")):
        with pytest.raises(InputError) as caught:
            region_profile(with_loss(0.1), name, inside)
        assert caught.value.where == where
    with pytest.raises(InputError) as caught:
        region_profile(left(smoothness(0.1)), NAME, ABOVE)
    assert caught.value.where == "left.loss"
