"""Spikes that were put in are found, and nothing else: noise, bends and the lamp stay."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from box_scene import write_block
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.observe import (
    Heater,
    Recording,
    Run,
    Scene,
    estimate_noise,
    read_scene,
    without_spikes,
)
from thermo.observe._spikes import spikes

FRAMES, SAMPLES, WHITE = 150, 60, 0.05
LAMP = Heater(np.zeros(3), np.array([0.0, 0.0, -1.0]), 0.01, 1.0, 14.0)


def run(seed: int, white: float) -> tuple[Run, np.ndarray]:
    """Heating as the square root of time until 14 s, then cooling; and the noise-free course."""
    random = np.random.default_rng(seed)
    time = 0.2 * np.arange(FRAMES)
    rise = np.sqrt(time) - np.where(time > 14.0, np.sqrt(np.maximum(time - 14.0, 0.0)), 0.0)
    clean = 295.0 + rise[:, None] * random.uniform(0.0, 8.0, SAMPLES)
    data = clean + white * random.standard_normal(clean.shape)
    record = Recording(np.zeros((SAMPLES, 3)), time, data)
    return Run("lamp", record, 295.0, 295.0, 295.0, heater=LAMP), clean


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**31), size=st.sampled_from([-2.0, 1.2, 30.0]))
def test_spikes_are_found_and_nothing_else_is(seed: int, size: float) -> None:
    plain, _ = run(seed, WHITE)
    assert spikes(plain).sum() <= 1
    random = np.random.default_rng(seed + 1)
    put = random.random((FRAMES, SAMPLES)) < 0.005
    # Near a jump of the sources the course bends, and at the end few readings follow.
    put[:20], put[60:90], put[-8:] = False, False, False
    record = plain.recording
    data = record.temperature + size * put
    found = spikes(replace(plain, recording=Recording(record.points, record.time, data)))
    assert np.mean(found[put]) > 0.97 and (found & ~put).sum() <= 2


@pytest.mark.parametrize("white", [0.0, 1e-4])
def test_a_course_without_noise_bends_and_stays(white: float) -> None:
    assert spikes(run(0, white)[0]).sum() == 0


def test_missing_readings_and_few_frames_are_no_spikes() -> None:
    plain, _ = run(3, WHITE)
    record = plain.recording
    gaps = np.random.default_rng(0).random(record.valid.shape) > 0.4
    assert spikes(replace(plain, recording=replace(record, valid=gaps))).sum() <= 1
    for frames in (2, 4, 6):
        short = Recording(record.points, record.time[:frames], record.temperature[:frames])
        assert spikes(replace(plain, recording=short)).sum() == 0


@pytest.mark.parametrize("step", [0.1, 0.5])
def test_a_thermometer_that_rounds_flickers_and_keeps_its_readings(step: float) -> None:
    plain, _ = run(5, WHITE)
    record = plain.recording
    coarse = Recording(record.points, record.time, step * np.round(record.temperature / step))
    assert spikes(replace(plain, recording=coarse)).sum() == 0


def test_quiet_frames_lose_their_spikes_and_the_noise_is_as_without(scene: Scene) -> None:
    lamp = scene.runs["lamp"]
    assert lamp.recording.quiet is not None
    quiet = lamp.recording.quiet.copy()
    quiet[3, 4] += 2.0
    old = lamp.recording
    spiky = Recording(old.points, old.time, old.temperature, old.valid, quiet)
    runs = {**scene.runs, "lamp": replace(lamp, recording=spiky)}
    cleaned, counts = without_spikes(replace(scene, runs=runs))
    left = cleaned.runs["lamp"].recording
    assert counts["lamp"] == 1 and left.quiet is not None and np.isnan(left.quiet[3, 4])
    assert np.isnan(left.quiet).sum() == 1
    assert estimate_noise(left).white == pytest.approx(estimate_noise(old).white, rel=0.02)
    assert estimate_noise(spiky).white > 5 * estimate_noise(old).white


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    folder: Path = write_block(tmp_path_factory.mktemp("spiky"))
    return read_scene(folder)


def test_of_a_scene_only_spikes_are_dropped(scene: Scene) -> None:
    whole, before = without_spikes(scene)
    assert set(before) == set(scene.runs) and sum(before.values()) <= 1
    old = scene.runs["cooling"].recording
    data = old.temperature.copy()
    data[14, 5] += 5.0
    spiky = Recording(old.points, old.time, data, old.valid, old.quiet)
    changed = {**scene.runs, "cooling": replace(scene.runs["cooling"], recording=spiky)}
    cleaned, counts = without_spikes(replace(scene, runs=changed))
    assert counts == {**before, "cooling": before["cooling"] + 1}
    record = cleaned.runs["cooling"].recording
    assert not record.valid[14, 5]
    assert record.valid.sum() == whole.runs["cooling"].recording.valid.sum() - 1
    assert cleaned.runs["lamp"].heater is scene.runs["lamp"].heater


def test_of_a_camera_nothing_is_dropped() -> None:
    bracket = Path(__file__).parents[2] / "examples" / "bracket"
    scene = read_scene(bracket)
    cleaned, counts = without_spikes(scene)
    for name, run in cleaned.runs.items():
        assert np.array_equal(run.recording.valid, scene.runs[name].recording.valid)
    # Of the quiet frames' 40 000 readings, one that chance put far off.
    assert sum(counts.values()) <= 1
