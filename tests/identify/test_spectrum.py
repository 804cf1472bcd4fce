"""Spectrum: the formulas of a linear fit with a prior, what is hidden, and a body that cools."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from box_scene import write_block
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.fields import QUANTITIES
from thermo.identify import identifiability, spectrum
from thermo.identify._information import information, pulls
from thermo.inverse import Meshing, Sensitivity, Stepping, sensitivity

pytestmark = pytest.mark.usefixtures("bricks")

NAMES = ("conductivity", "convection", "emissivity")
PRIOR = {"conductivity": 0.5, "convection": 1.0, "emissivity": 0.2}
FRAMES, SAMPLES = 6, 5


def made(seed: int, noise: float = 0.3, accuracy: float = 0.0) -> Sensitivity:
    random = np.random.default_rng(seed)
    slopes = {name: random.standard_normal((FRAMES, SAMPLES, 3)) for name in ("a", "b")}
    return Sensitivity(NAMES, slopes, {"a": noise, "b": 2 * noise}, accuracy)


@given(seed=st.integers(0, 999), model=st.floats(0.0, 2.0))
@settings(max_examples=30, deadline=None)
def test_covariance_and_shares_are_those_of_a_linear_fit(seed: int, model: float) -> None:
    at = made(seed)
    found = spectrum(at, prior=PRIOR, model_error=model)
    information = np.diag([PRIOR[name] ** -2.0 for name in NAMES])
    for run, slopes in at.slopes.items():
        noise = at.noise[run]
        covariance = noise**2 * np.eye(FRAMES) + model**2
        for sample in range(SAMPLES):
            each = slopes[:, sample]
            information += each.T @ np.linalg.solve(covariance, each)
    wanted = np.linalg.inv(information)
    assert found.covariance() == pytest.approx(wanted, rel=1e-8, abs=1e-12)
    assert found.deviation() == pytest.approx(np.sqrt(np.diagonal(wanted)), rel=1e-8)
    shares = found.informed()
    assert np.all((shares > 0) & (shares < 1))
    assert shares.sum() == pytest.approx(found.known().sum(), rel=1e-9)
    assert np.diagonal(found.correlation()) == pytest.approx(1.0)


@given(seed=st.integers(0, 999), frame=st.floats(0.01, 2.0), lasting=st.floats(0.0, 1.0))
@settings(max_examples=20, deadline=None)
def test_what_samples_have_in_common_is_allowed_for_as_their_covariance_asks(
    seed: int, frame: float, lasting: float
) -> None:
    at = replace(made(seed), common={"a": (frame, lasting)})
    defect = {"a": np.random.default_rng(seed).standard_normal((FRAMES, SAMPLES))}
    at = replace(at, defect=defect)
    wanted, pulled = np.zeros((3, 3)), np.zeros(3)
    for run, slopes in at.slopes.items():
        frames, samples = np.divmod(np.arange(FRAMES * SAMPLES), SAMPLES)
        covariance = at.noise[run] ** 2 * np.eye(len(frames))
        covariance += 0.3**2 * (samples[:, None] == samples)
        if run == "a":
            covariance += frame**2 * (frames[:, None] == frames) + lasting**2
        rows = slopes.reshape(-1, 3)
        wanted += rows.T @ np.linalg.solve(covariance, rows)
        if run == "a":
            pulled = rows.T @ np.linalg.solve(covariance, defect["a"].ravel())
    assert information(at, 0.3) == pytest.approx(wanted, rel=1e-8, abs=1e-9)
    assert pulls(at, 0.3)[:, 0] == pytest.approx(pulled, rel=1e-8, abs=1e-9)


def test_the_prior_is_even_over_the_bounds_where_none_is_given() -> None:
    quantity = QUANTITIES["emissivity"]
    drawn = np.random.default_rng(0).uniform(
        np.log(quantity.lower), np.log(quantity.upper), 200_000
    )
    found = spectrum(made(0), prior={"conductivity": 0.5})
    assert found.prior[2] == pytest.approx(np.std(drawn), rel=0.01) and found.prior[0] == 0.5


def test_a_direction_without_data_is_left_to_the_prior() -> None:
    at = made(1)
    for slopes in at.slopes.values():
        slopes[..., 2] = -2 * slopes[..., 0]
    found = spectrum(at, prior=PRIOR)
    assert found.data_led() == 2
    (one,) = found.undetermined()
    assert one.weights == pytest.approx({"conductivity": 1.0, "emissivity": 0.5})
    # Conductivity and emissivity cannot both be informed, however small the noise.
    clear = spectrum(
        Sensitivity(NAMES, at.slopes, dict.fromkeys("ab", 1e-6)), prior=PRIOR, model_error=0.0
    )
    assert clear.informed()[1] > 0.999 and clear.informed()[[0, 2]].sum() < 1.001
    assert clear.data_led() == 2 and abs(clear.correlation()[0, 2]) > 0.999


def test_slopes_of_a_loose_solver_do_not_make_a_direction() -> None:
    random = np.random.default_rng(2)
    at = made(2, noise=1e-5)
    for slopes in at.slopes.values():
        error = 1e-4 * random.standard_normal(slopes.shape[:2])
        slopes[..., 2] = slopes[..., 0] * (1 + error)
    believed = spectrum(at, prior=PRIOR, model_error=0.0)
    assert believed.data_led() == 3 and believed.undetermined() == []
    loose = Sensitivity(NAMES, at.slopes, at.noise, accuracy=1e-4)
    doubted = spectrum(loose, prior=PRIOR, model_error=0.0)
    assert doubted.data_led() == 2
    (one,) = doubted.undetermined()
    assert one.weights == pytest.approx({"conductivity": 1.0, "emissivity": -1.0}, abs=1e-3)


def test_values_of_one_quantity_are_numbered() -> None:
    names = ("conductivity", "conductivity", "convection")
    at = made(3)
    found = spectrum(Sensitivity(names, at.slopes, at.noise))
    assert found.names == ("conductivity[0]", "conductivity[1]", "convection")


@pytest.mark.parametrize(
    ("prior", "model", "where"),
    [
        ({"conductivity": 0.0}, 0.01, "prior.conductivity"),
        ({"diffusivity": 0.1}, 0.01, "prior.diffusivity"),
        ({}, -1.0, "model_error"),
    ],
)
def test_what_cannot_be_is_refused(prior: dict[str, float], model: float, where: str) -> None:
    with pytest.raises(InputError) as caught:
        spectrum(made(0), prior=prior, model_error=model)
    assert caught.value.where == where


def part(at: Sensitivity, runs: tuple[str, ...], names: tuple[str, ...]) -> Sensitivity:
    """Some of the runs, and some of the unknowns: the others are known."""
    kept = [at.names.index(name) for name in names]
    slopes = {run: at.slopes[run][..., kept] for run in runs}
    values = tuple(at.values[number] for number in kept)
    return replace(at, names=names, slopes=slopes, values=values)


def test_cooling_alone_tells_ratios_a_lamp_the_rest_and_its_power_hides_that_again(
    tmp_path: Path,
) -> None:
    block = write_block(tmp_path / "block")
    body = ("conductivity", "volumetric_heat_capacity", "convection")
    every = sensitivity(
        block,
        runs=("cooling", "lamp"),
        unknown=body,
        scales=("heater_power", "camera_emissivity"),
        initial={"conductivity": 0.8},
        meshing=Meshing(order=1, max_nodes=1000, cache=tmp_path / "meshes"),
        stepping=Stepping(tolerance=0.1, rtol=1e-9),
    )
    assert every.values[0] == pytest.approx(0.8) and every.values[-1] == 1.0
    cooling = spectrum(part(every, ("cooling",), body))
    (one,) = cooling.undetermined()
    assert one.weights == pytest.approx(dict.fromkeys(body, 1.0), abs=1e-4)
    assert "only their ratios are determined" in one.words()
    # With a tight solver the data see nothing of it, to the square of its error.
    assert cooling.eigenvalues[-1] < 1e-10 * cooling.eigenvalues[0]
    both = spectrum(part(every, ("cooling", "lamp"), body))
    assert both.undetermined() == [] and both.deviation().max() < 0.05
    powered = part(every, ("cooling", "lamp"), (*body, "heater_power"))
    told = identifiability(powered)
    (one,) = told.free
    assert one.weights == pytest.approx(dict.fromkeys(powered.names, 1.0), abs=1e-4)
    assert {item.verdict for item in told.findings} == {"not_identified"}
    dark = spectrum(part(every, ("cooling",), ("conductivity", "heater_power")))
    assert [one.words() for one in dark.undetermined()] == ["heater_power is not determined"]
    # A lamp that is stronger, and a camera that reads less of what it does.
    gained = spectrum(part(every, ("lamp",), ("heater_power", "camera_emissivity")))
    (one,) = gained.undetermined()
    assert one.weights == pytest.approx({"heater_power": 1.0, "camera_emissivity": -1.0}, abs=1e-4)
