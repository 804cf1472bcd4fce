"""A model that learns the noise of its runs from what it leaves of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

from thermo.inverse import LogModel, Meshing, Stepping, log_model, residual_noises, with_noise
from thermo.inverse._run_fit import differences
from thermo.observe import Recording, Scene, read_scene

pytestmark = pytest.mark.usefixtures("bricks")

WHITE, KEPT, OFFSET = 0.3, 0.5, 0.6
NONE = 0.01  # K, of the simulation


def noisy(frames: int, samples: int) -> np.ndarray:
    """Errors of readings [K] that fade from frame to frame and stay."""
    random = np.random.default_rng(0)
    error = WHITE * random.standard_normal((frames, samples))
    for frame in range(1, frames):
        error[frame] = KEPT * error[frame - 1] + np.sqrt(1 - KEPT**2) * error[frame]
    return error + OFFSET * random.standard_normal(samples)


@pytest.fixture(scope="module")
def plain(block: Path) -> Scene:
    """The block under the lamp, without quiet frames."""
    found = read_scene(block)
    run = found.runs["lamp"]
    old = run.recording
    record = Recording(old.points, old.time, old.temperature, None, None)
    return replace(found, runs={"lamp": replace(run, recording=record)})


@pytest.fixture(scope="module")
def model(plain: Scene, tmp_path_factory: pytest.TempPathFactory) -> LogModel:
    """Its readings are its own simulation with errors: nothing else is wrong."""
    folder = tmp_path_factory.mktemp("coarse")
    made = log_model(
        plain, unknown=("conductivity",), model_error=NONE, initial={"conductivity": 0.8},
        meshing=Meshing(order=1, max_nodes=600, corrected=False, cache=folder),
        stepping=Stepping(tolerance=0.1, rtol=1e-9),
    )  # fmt: skip
    (apart,) = differences(made.objective, jnp.asarray(made(made.first)[0]))
    (case,) = made.objective.cases
    exact = replace(case, data=case.data + apart + noisy(*case.data.shape[1:]))
    return replace(made, objective=replace(made.objective, cases=(exact,)))


def test_the_noise_of_a_run_without_quiet_frames_is_learnt(model: LogModel, plain: Scene) -> None:
    noise = residual_noises(model, plain)["lamp"].noise
    # Some twenty pairs of thirty samples, 21 frames each.
    assert noise.white == pytest.approx(WHITE, rel=0.25)
    assert noise.correlation == pytest.approx(KEPT, abs=0.2)
    # A median of twenty knows a deviation to a quarter.
    assert noise.offset == pytest.approx(OFFSET, rel=0.6)


def test_residuals_are_white_beside_it_and_were_not_before(model: LogModel, plain: Scene) -> None:
    learnt = with_noise(model, plain, residual_noises(model, plain), model_error=NONE)
    count = model.objective.cases[0].data.size
    before, after = (np.mean(one(model.first)[0][:count] ** 2) for one in (model, learnt))
    assert before > 2 and after == pytest.approx(1.0, abs=0.25)


def test_quiet_frames_come_first_and_what_learns_nothing_is_the_same(
    model: LogModel, plain: Scene
) -> None:
    run = plain.runs["lamp"]
    old = run.recording
    quiet = run.initial_temperature + noisy(12, len(old.points))
    record = Recording(old.points, old.time, old.temperature, None, quiet)
    known = replace(plain, runs={"lamp": replace(run, recording=record)})
    assert residual_noises(model, known) == {}
    assert with_noise(model, known, {}, model_error=NONE) is model
