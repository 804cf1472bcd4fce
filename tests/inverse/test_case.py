"""A run made ready for a fit: data without the offsets, weights, stacking of unequal runs."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.errors import InputError
from thermo.inverse._case import Case, group_cases, in_kelvin, make_case, stack_cases
from thermo.inverse._reading_errors import whiten
from thermo.observe import Noise, Recording, Run, Scene, estimate_noise
from thermo.physics import discretise, uniform_steps

from .objectives import MESH, case

SPACE = discretise(MESH)


def recorded(run: Run, *, quiet: np.ndarray | None = None, shift: float = 0.0) -> Run:
    old = run.recording
    values = np.where(old.valid, old.temperature + shift, np.nan)
    return replace(run, recording=Recording(old.points, old.time, values, None, quiet))


def test_a_constant_error_known_from_quiet_frames_is_taken_off(scene: Scene) -> None:
    run = scene.runs["lamp"]
    samples = len(run.recording.points)
    wave = np.linspace(-0.4, 0.5, samples)
    ripple = 0.01 * np.resize([1.0, -1.0], 6)[:, None]
    quiet = run.initial_temperature + wave + ripple
    old = run.recording
    values = np.where(old.valid, old.temperature + wave, np.nan)
    shifted = replace(run, recording=Recording(old.points, old.time, values, None, quiet))
    plain = recorded(run, quiet=run.initial_temperature + np.zeros(samples) + ripple)
    used = np.asarray(old.valid)
    found, wanted = np.asarray(case(shifted).data), np.asarray(case(plain).data)
    assert np.allclose(found[used], wanted[used], atol=1e-10)


def test_without_quiet_frames_what_is_stated_of_constant_errors_stays(scene: Scene) -> None:
    run = recorded(scene.runs["lamp"])
    told = case(replace(run, constant_error=0.3))
    np.testing.assert_allclose(told.errors.staying, 0.09)
    np.testing.assert_array_equal(case(run).errors.staying, 0.0)
    # What is left in the readings is not pinned by quiet frames.
    assert not np.any(told.pinned)


def test_noise_that_is_stated_counts_in_place_of_what_the_recording_tells(scene: Scene) -> None:
    run = recorded(scene.runs["lamp"])
    assert run.noise_of_readings() == estimate_noise(run.recording)
    told = replace(run, noise=Noise(0.07, 0.2, 0.5))
    assert told.noise_of_readings() == Noise(0.07, 0.2, 0.5)
    errors = case(told).errors
    np.testing.assert_allclose(errors.staying, 0.04)
    np.testing.assert_allclose(errors.fading, 0.07**2)
    np.testing.assert_allclose(np.asarray(errors.kept)[1:], 0.5)
    # Of what a run states and of what its noise has the larger one counts.
    stated = case(replace(told, constant_error=0.3)).errors
    np.testing.assert_allclose(stated.staying, 0.09)


def test_an_error_that_quiet_frames_tell_is_not_stated_as_well(scene: Scene) -> None:
    run = scene.runs["lamp"]
    samples = len(run.recording.points)
    quiet = run.initial_temperature + 0.01 * np.resize([1.0, -1.0], 5)[:, None] + np.zeros(samples)
    with pytest.raises(InputError, match="beside quiet frames"):
        replace(recorded(run, quiet=quiet), constant_error=0.3)
    pinned = np.asarray(case(recorded(run, quiet=quiet)).pinned)
    np.testing.assert_array_equal(pinned, 1.0)


def test_two_quiet_frames_are_too_few_for_an_offset(scene: Scene) -> None:
    run = scene.runs["lamp"]
    samples = len(run.recording.points)
    few = recorded(run, quiet=np.full((2, samples), run.initial_temperature + 1.0))
    assert np.array_equal(np.asarray(case(few).data), few.recording.temperature)


def test_a_sample_that_is_never_quiet_keeps_its_values(scene: Scene) -> None:
    run = scene.runs["lamp"]
    quiet = np.full((5, len(run.recording.points)), run.initial_temperature + 1.0)
    quiet += 0.01 * np.resize([1.0, -1.0], 5)[:, None]
    with_hole = quiet.copy()
    with_hole[:, 4] = np.nan
    made = case(recorded(run, quiet=with_hole))
    difference = run.recording.temperature - np.asarray(made.data)
    assert np.allclose(difference[:, 4], 0.0)
    assert np.allclose(np.delete(difference, 4, axis=1), quiet[:, 0].mean() - 295.0)


def test_weights_are_one_over_the_deviation_and_zero_without_data(scene: Scene) -> None:
    run = scene.runs["lamp"]
    white = estimate_noise(run.recording).white
    made = case(run)
    weight = np.asarray(made.weight())
    used = run.recording.valid
    staying = np.asarray(made.errors.staying)
    wanted = (white**2 + 0.01**2 + staying) ** -0.5
    assert np.allclose(weight[used], np.broadcast_to(wanted, used.shape)[used], rtol=1e-12)
    assert not run.recording.valid[5, 3]
    assert np.all(weight[~run.recording.valid] == 0)
    assert (weight == 0).sum() == 3
    assert np.isfinite(np.asarray(case(run).data)).all()


def test_errors_fade_as_the_quiet_frames_do_and_a_part_of_each_offset_stays(scene: Scene) -> None:
    run = scene.runs["lamp"]
    random, samples = np.random.default_rng(0), len(run.recording.points)
    wave = np.zeros((400, samples))
    for frame in range(1, len(wave)):
        wave[frame] = 0.6 * wave[frame - 1] + 0.8 * random.standard_normal(samples)
    run = recorded(run, quiet=run.initial_temperature + 0.05 * wave)
    grid = uniform_steps(run.recording.time[[0, 3, 4, 20]], 5.0)
    errors = make_case(run, SPACE, grid, model_error=0.01, where="scene.json").errors
    assert float(errors.fading) == pytest.approx(0.05**2, rel=0.1)
    kept = np.asarray(errors.kept)[1:]
    assert kept == pytest.approx(kept[1] ** np.array([3, 1, 16])), "as many frames lie between"
    assert kept[1] == pytest.approx(0.6, abs=0.05)
    assert np.allclose(errors.own, 0.01**2)
    # The mean of 400 frames, four of which say the same.
    assert np.allclose(errors.staying, 0.05**2 * 4 / 400, rtol=0.3)


def test_noise_of_its_own_in_each_reading_does_not_fade(scene: Scene) -> None:
    run = scene.runs["lamp"]
    samples = np.resize([1.0, -1.0], len(run.recording.points))
    quiet = run.initial_temperature + 0.05 * np.resize([1.0, -1.0], 10)[:, None] * samples
    run = recorded(run, quiet=quiet)
    white = estimate_noise(run.recording).white
    errors = case(run).errors
    assert float(errors.fading) == 0.0
    assert np.allclose(errors.own, white**2 + 0.01**2)
    assert np.allclose(errors.staying, white**2 / 10)
    assert errors.common is None


def off_as_a_whole(run: Run, size: float) -> Run:
    """The run with ten quiet frames, each off by so much [K] in all samples beside its noise."""
    random = np.random.default_rng(1)
    error = 0.05 * random.standard_normal((10, len(run.recording.points)))
    common = size * random.standard_normal((10, 1))
    return recorded(run, quiet=run.initial_temperature + error + common)


def test_what_quiet_frames_have_in_common_is_in_the_errors_of_all_samples(scene: Scene) -> None:
    run = off_as_a_whole(scene.runs["lamp"], 0.1)
    found = estimate_noise(run.recording)
    made = case(run)
    assert made.errors.common is not None and 0.05 < found.frame < 0.2
    alone = replace(made.errors, common=None)
    # Each by itself, and the mean of ten that the constant errors are off by.
    assert np.allclose(made.errors.variance() - alone.variance(), found.frame**2 * 1.1)
    alike = jnp.ones_like(made.data) * made.used
    before, after = (float(jnp.sum(whiten(one, made.used, alike) ** 2))
                     for one in (alone, made.errors))  # fmt: skip
    frames = made.data.shape[0]
    # Of one kelvin in common: known by the frames together, and by no more than ten were.
    assert after < 1 / (found.frame**2 / frames + found.frame**2 / 10) < before / 5
    kelvin = in_kelvin(made)
    assert kelvin.errors.common is None and np.all(kelvin.weight()[made.used > 0] == 1)


def test_common_errors_are_padded_and_stacked_apart_from_others(scene: Scene) -> None:
    lamp, cooling = (off_as_a_whole(scene.runs[name], 0.1) for name in ("lamp", "cooling"))
    old = cooling.recording
    fewer = Recording(
        old.points[:20], old.time[:13], old.temperature[:13, :20], old.valid[:13, :20],
        None if old.quiet is None else old.quiet[:, :20],
    )  # fmt: skip
    cases = [case(lamp), case(scene.runs["lamp"]), case(replace(cooling, recording=fewer))]
    assert group_cases(cases) == [[0, 2], [1]]
    stacked = stack_cases(cases)[0]
    short = cases[2]
    padded = jax.tree.map(lambda leaf: leaf[1], stacked)
    apart = np.random.default_rng(0).standard_normal(short.data.shape)
    wide = np.zeros(padded.data.shape)
    wide[:13, :20] = apart
    found = np.asarray(whiten(padded.errors, padded.used, jnp.asarray(wide)))
    wanted = np.asarray(whiten(short.errors, short.used, jnp.asarray(apart)))
    np.testing.assert_allclose(found[:13, :20], wanted, atol=1e-9)
    assert np.all(found[13:] == 0) and np.all(found[:, 20:] == 0)


def test_a_case_takes_the_frames_of_its_grid(scene: Scene) -> None:
    run = scene.runs["lamp"]
    some = run.recording.time[[0, 3, 4, 20]]
    made = make_case(
        run, SPACE, uniform_steps(some, 5.0), model_error=0.01, where="scene.json"
    )  # fmt: skip
    assert made.data.shape == (4, len(run.recording.points))
    whole = case(run)
    assert np.array_equal(np.asarray(made.data), np.asarray(whole.data)[[0, 3, 4, 20]])
    assert np.array_equal(np.asarray(made.used), np.asarray(whole.used)[[0, 3, 4, 20]])


def test_samples_away_from_the_surface_are_refused(scene: Scene) -> None:
    run = scene.runs["lamp"]
    old = run.recording
    far = Recording(old.points + [0.0, 0.0, 1.0], old.time, old.temperature, old.valid)
    with pytest.raises(InputError) as caught:
        case(replace(run, recording=far))
    assert "scene.json" in caught.value.where


def unequal(scene: Scene) -> list[Case]:
    """Two runs with other numbers of frames, samples and steps."""
    lamp, cooling = scene.runs["lamp"], scene.runs["cooling"]
    old = cooling.recording
    fewer = Recording(
        old.points[:20], old.time[:13], old.temperature[:13, :20], old.valid[:13, :20]
    )
    return [case(lamp), case(replace(cooling, recording=fewer), size=9.0)]


def test_stacked_runs_are_padded_with_steps_of_no_time_and_data_of_no_weight(scene: Scene) -> None:
    cases = unequal(scene)
    (stacked,) = stack_cases(cases)
    assert len({len(one.grid.start) for one in cases}) == 2
    assert stacked.data.shape == (2, 21, 30)
    for number, one in enumerate(cases):
        mine = jax.tree.map(lambda leaf, n=number: np.asarray(leaf)[n], stacked)
        frames, samples = one.data.shape
        steps = len(one.grid.start)
        assert np.array_equal(mine.data[:frames, :samples], np.asarray(one.data))
        assert np.array_equal(mine.used[:frames, :samples], np.asarray(one.used))
        assert np.all(mine.used[frames:] == 0) and np.all(mine.used[:, samples:] == 0)
        assert np.all(mine.grid.size[steps:] == 0)
        assert mine.grid.size.sum() == pytest.approx(np.sum(one.grid.size), rel=1e-12)
        assert np.all(np.diff(mine.grid.start) >= 0) and np.all(np.diff(mine.grid.frame_step) >= 0)


def test_runs_of_another_structure_are_not_stacked(scene: Scene) -> None:
    lamp, cooling = case(scene.runs["lamp"]), case(scene.runs["cooling"])
    of_faces = ("profile", "exposed", "own", "known", "warmer")
    fewer = {name: getattr(lamp.under, name)[:-1] for name in of_faces}
    other = replace(cooling, under=replace(cooling.under, **fewer))
    cases = [lamp, other, case(scene.runs["test_lamp"])]
    groups = stack_cases(cases)
    assert [len(group.data) for group in groups] == [2, 1]
    assert group_cases(cases) == [[0, 2], [1]]
    np.testing.assert_array_equal(groups[0].data[1, : len(cases[2].data)], cases[2].data)
