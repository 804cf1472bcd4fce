"""A surface whose scale is known roughly, against what dimensions say."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np
import pytest
from box_scene import CONDUCTIVITY, CONVECTION, DENSITY, HEAT_CAPACITY
from bricks import lay_bricks

from thermo.identify import findings, identifiability, shifts, spectrum
from thermo.inverse import (
    Estimate,
    Meshing,
    OnControlPoints,
    Prior,
    ScaleEffect,
    Sensitivity,
    Stepping,
    Uniform,
    invert,
    posterior,
    sensitivity,
)
from thermo.inverse._surface_scale import TIGHT, _scaled_run
from thermo.observe import Air, Box, Scene
from thermo.physics.integrators import BackwardEuler

from .walk import Walk

ROUGH = 0.02
STARTS = {
    "conductivity": CONDUCTIVITY,
    "convection": CONVECTION,
    "volumetric_heat_capacity": DENSITY * HEAT_CAPACITY,
}
# A body that cools shows k / (rho c L^2) and h / (rho c L), and nothing else.
POWERS = {"conductivity": 2.0, "convection": 1.0}
# Under a lamp of a power in watts it shows k L, h L^2 and rho c L^3.
LIT = {"conductivity": -1.0, "convection": -2.0, "volumetric_heat_capacity": -3.0}
HOW = {
    # As exact as where the scale goes up and down, so that both are one program.
    "stepping": Stepping(BackwardEuler(), size=1.5, rtol=TIGHT),
    "meshing": Meshing(order=1, corrected=False, coarse_tangents=False),
}


@pytest.fixture(scope="module")
def rough(scene: Scene) -> Iterator[Scene]:
    """The block made of bricks, its scale known to 2 %."""
    with pytest.MonkeyPatch.context() as patch:
        lay_bricks(patch, (5, 3, 2))
        yield replace(scene, scale_deviation=ROUGH)


@pytest.fixture(scope="module")
def told(rough: Scene) -> Estimate:
    """Both values of the block from how it cools."""
    return fit(rough)


def fit(scene: Scene, **more: object) -> Estimate:
    asked = {"unknown": tuple(POWERS), "initial": STARTS, "choice": Uniform(), **HOW, **more}
    return invert(scene, runs=("cooling",), **asked)  # pyright: ignore


def effect_of(estimate: Estimate) -> ScaleEffect:
    assert estimate.scale is not None
    return estimate.scale


def test_time_alone_tells_squares_of_lengths_and_lengths(told: Estimate) -> None:
    effect = effect_of(told)
    assert effect.deviation == ROUGH
    assert effect.change == pytest.approx(POWERS, rel=2e-3)
    for name, power in POWERS.items():
        wanted = np.hypot(effect.without[name], power * ROUGH)
        assert effect.total(name) == pytest.approx(wanted, rel=2e-3)
        assert 0 < effect.without[name] < wanted
        assert effect.share(name) == pytest.approx((power * ROUGH / wanted) ** 2, rel=5e-3)


def test_an_exact_scale_says_nothing_and_moves_nothing(rough: Scene, told: Estimate) -> None:
    exact = fit(replace(rough, scale_deviation=0.0))
    assert exact.scale is None and not any("scale" in one for one in exact.remarks)
    for name in POWERS:
        assert np.array_equal(exact.fields[name].cells, told.fields[name].cells)
    assert sum("scale is known to 2 %" in one for one in told.remarks) == 2


def test_fields_move_as_values_do(rough: Scene) -> None:
    # A smooth field is free to move as a whole, so smoothness does not hold it back.
    # What it does is the same wherever a fit ends, and one step that looks at nothing ends sooner.
    how = {"choice": OnControlPoints(4), "prior": Prior(step=0.1), "optimiser": Walk(max_steps=1)}
    effect = effect_of(fit(rough, **how))
    assert effect.change == pytest.approx(POWERS, rel=5e-3)


def test_a_prior_holds_a_value_back(rough: Scene, told: Estimate) -> None:
    prior = Prior(spread={"convection": 1e-6})
    held = effect_of(fit(rough, prior=prior))
    assert abs(held.change["convection"]) < 0.01
    assert held.without["convection"] == pytest.approx(1e-6, rel=0.02)
    assert effect_of(told).change["convection"] > 0.99


def slopes_of(scene: Scene) -> Sensitivity:
    """Those of both runs by all three values."""
    runs = ("lamp", "cooling")
    return sensitivity(scene, unknown=tuple(LIT), runs=runs, initial=STARTS, **HOW)  # pyright: ignore


@pytest.fixture(scope="module")
def sensed(rough: Scene) -> Sensitivity:
    return slopes_of(rough)


def part(whole: Sensitivity, run: str, names: Collection[str]) -> Sensitivity:
    """What it says of one run and of these values."""
    kept = [number for number, name in enumerate(whole.names) if name in names]
    return replace(
        whole,
        names=tuple(whole.names[number] for number in kept),
        values=tuple(whole.values[number] for number in kept),
        slopes={run: whole.slopes[run][..., kept]},
        scale={name: one for name, one in whole.scale.items() if name == run},
        noise={run: whole.noise[run]},
        staying={run: whole.staying[run]},
        common={run: whole.common[run]},
    )


def test_a_lamp_keeps_its_power(sensed: Sensitivity) -> None:
    at = part(sensed, "lamp", LIT)
    moved = {one.name: one.relative / one.doubt for one in shifts(at, {})}
    assert moved == pytest.approx(LIT, rel=0.02)


def test_intervals_take_the_scale_in(rough: Scene, sensed: Sensitivity) -> None:
    at = part(sensed, "cooling", POWERS)
    exact = part(slopes_of(replace(rough, scale_deviation=0.0)), "cooling", POWERS)
    assert not exact.scale and np.array_equal(exact.slopes["cooling"], at.slopes["cooling"])
    before = {one.name: one for one in identifiability(exact).findings}
    for one in findings(at, spectrum(at)):
        wanted = np.hypot(before[one.name].relative, POWERS[one.name] * ROUGH)
        assert one.relative == pytest.approx(wanted, rel=5e-3)
    moved = {one.name: one.relative / ROUGH for one in shifts(at, {})}
    assert moved == pytest.approx(POWERS, rel=5e-3)
    assert not shifts(exact, {})


def test_bands_of_fields_take_the_scale_in(rough: Scene, told: Estimate) -> None:
    asked = {"count": 6, "runs": ("cooling",), "prior": Prior(step=0.1), **HOW}
    left = posterior(rough, told, **asked)
    exact = posterior(replace(rough, scale_deviation=0.0), told, **asked)
    for name, power in POWERS.items():
        with_scale, without = (one.mean(name)[1] for one in (left, exact))
        assert np.sqrt(with_scale**2 - without**2) == pytest.approx(power * ROUGH, rel=0.02)


def test_the_boxes_of_a_run_are_scaled_with_its_surface(scene: Scene) -> None:
    box = Box([0.0, 0.1, 0.2], [0.3, 0.4, 0.5])
    run = replace(scene.runs["cooling"], insulated=(box,), air=(Air(box, 4.0, 300.0),))
    scaled = _scaled_run(run, 2.0)
    for one in (scaled.insulated[0], scaled.air[0].box):
        np.testing.assert_allclose([one.low, one.high], [[0.0, 0.2, 0.4], [0.6, 0.8, 1.0]])
    assert (scaled.air[0].convection, scaled.air[0].temperature) == (4.0, 300.0)
