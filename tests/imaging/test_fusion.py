"""Frames brought to a surface."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from cameras import camera_at

from thermo.errors import InputError
from thermo.imaging import Camera, Frames, looks_of, place_samples
from thermo.imaging._fusion import register_frames
from thermo.imaging._pixel_map import look
from thermo.imaging._usable import places_of
from thermo.mesh import Surface

MESH = trimesh.creation.box([0.06, 0.08, 0.05])
BOX = Surface(np.asarray(MESH.vertices), np.asarray(MESH.faces, dtype=np.int64))
CAMERAS = [
    camera_at((0.3, 0.1, 0.1), size=(64, 48), focal=110.0, name="front"),
    camera_at((0.25, 0.2, 0.15), size=(48, 48), focal=100.0, name="beside"),
]
TIME = np.arange(-3.0, 6.0) / 4
SLOPE = np.array([30.0, -50.0, 20.0])


def film(camera: Camera, time: np.ndarray = TIME) -> np.ndarray:
    """A temperature linear over space and, after 0, over time; the room behind it."""
    places = places_of(BOX, look(camera, BOX))
    rise = 300.0 + places @ SLOPE
    seen = rise + 5.0 * np.maximum(time, 0.0)[:, None, None]
    return np.where(np.isnan(seen), 280.0, seen)


def test_a_linear_field_comes_back_from_both_cameras() -> None:
    frames = [Frames(TIME, film(one)) for one in CAMERAS]
    samples = place_samples(looks_of(BOX, CAMERAS), count=200)
    record = register_frames(samples, CAMERAS, frames)
    assert record.quiet is not None and len(record.quiet) == 3
    np.testing.assert_allclose(record.time, TIME[3:])
    truth = 300.0 + record.points @ SLOPE + 5.0 * record.time[:, None]
    assert record.valid.all() and samples.seen.all(axis=0).sum() > 30
    # A pixel's picture of a plane is linear up to perspective: some per cent of a pixel's change.
    assert np.abs(record.temperature - truth).max() < 5e-3
    np.testing.assert_allclose(record.quiet[0], 300.0 + record.points @ SLOPE, atol=5e-3)


def test_the_camera_that_sees_more_closely_counts_more() -> None:
    frames = [Frames(TIME, np.full((9, one.height, one.width), 300.0 + k))
              for k, one in enumerate(CAMERAS)]  # fmt: skip
    samples = place_samples(looks_of(BOX, CAMERAS), count=100)
    made = register_frames(samples, CAMERAS, frames)
    both = samples.seen.all(axis=0)
    side = samples.footprint[:, both] ** -2.0
    want = 300.0 + side[1] / side.sum(axis=0)
    np.testing.assert_allclose(made.temperature[2, both], want, atol=1e-4)


def test_cameras_that_take_turns_leave_gaps_in_place_of_guesses() -> None:
    times = [TIME, TIME + 0.1]
    frames = [Frames(t, film(c, t)) for t, c in zip(times, CAMERAS, strict=True)]
    samples = place_samples(looks_of(BOX, CAMERAS), count=100)
    made = register_frames(samples, CAMERAS, frames)
    assert len(made.time) == 12
    seen = samples.seen
    first, second = made.valid[0], made.valid[1]
    times_now = made.time[:2]
    assert times_now.tolist() == pytest.approx([0.0, 0.1])
    assert np.array_equal(first, seen[0]) and np.array_equal(second, seen[1])


def test_a_dead_pixel_spoils_the_samples_beside_it_alone() -> None:
    values = film(CAMERAS[0])
    samples = place_samples(looks_of(BOX, CAMERAS[:1]), count=100)
    made = register_frames(samples, CAMERAS[:1], [Frames(TIME, values)])
    pixel = int(samples.pixels[0, 7, np.argmax(samples.weights[0, 7])])
    row, column = divmod(pixel, 64)
    dead = np.ones((9, 48, 64), bool)
    dead[5, row, column] = False
    values[6, row, column] = np.nan
    again = register_frames(samples, CAMERAS[:1], [Frames(TIME, values, dead)])
    assert not again.valid[2, 7] and not again.valid[3, 7]
    assert again.valid.sum() >= again.valid.size - 2 * 4
    kept = again.valid
    np.testing.assert_array_equal(again.temperature[kept], made.temperature[kept])


def test_what_does_not_fit_is_refused() -> None:
    fine = [Frames(TIME, film(one)) for one in CAMERAS]
    samples = place_samples(looks_of(BOX, CAMERAS), count=10)
    with pytest.raises(InputError, match="1 recordings, 2 cameras"):
        register_frames(samples, CAMERAS, fine[:1])
    with pytest.raises(InputError, match="48 x 48 pixels"):
        register_frames(samples, CAMERAS[:1], fine[1:])
    signal = Frames(TIME, film(CAMERAS[0]) * 40, counts=True)
    with pytest.raises(InputError, match="sensor's signal"):
        register_frames(samples, CAMERAS[:1], [signal])
    with pytest.raises(InputError, match="two frames of one camera"):
        register_frames(samples, CAMERAS, fine, together=0.3)
