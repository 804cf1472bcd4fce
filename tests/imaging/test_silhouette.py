"""Silhouettes against closed forms and cast rays; masks found in frames."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging import Camera, Frames, looking_at, pixel_centres, rays
from thermo.imaging._silhouette import mask_of, overlap, silhouette
from thermo.mesh import Surface

UP = np.array([0.0, 0.0, 1.0])


def camera_at(place: list[float], distortion: tuple[float, ...] = (0.0,) * 5) -> Camera:
    pose = looking_at(np.array(place), np.zeros(3), UP)
    return Camera(80, 60, (90.0, 95.0), (41.0, 28.0), pose, distortion)


def surface_of(mesh: trimesh.Trimesh) -> Surface:
    return Surface(np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64))


def test_a_square_fills_the_pixels_between_its_edges() -> None:
    box = surface_of(trimesh.creation.box(extents=(2.0, 2.0, 2e-9)))
    pose = np.eye(4)
    pose[2, 3] = 10.0
    camera = Camera(40, 30, (50.0, 40.0), (20.0, 15.0), pose)
    mask = silhouette(camera, box)
    # x from -1 to 1 at depth 10: 20 -+ 5 columns and 15 -+ 4 rows.
    wanted = np.zeros((30, 40), bool)
    wanted[11:20, 15:26] = True
    assert (mask == wanted).all()


def test_a_ball_is_seen_under_its_cone() -> None:
    radius, distance = 1.0, 5.0
    camera = camera_at([distance, 0.0, 0.0])
    ball = surface_of(trimesh.creation.icosphere(subdivisions=5, radius=radius))
    lines = rays(camera, pixel_centres(camera))
    sine = np.linalg.norm(np.cross(lines, [-1.0, 0.0, 0.0]), axis=1)
    wanted = (sine < radius / distance).reshape(60, 80)
    assert (silhouette(camera, ball) != wanted).sum() <= 4


@settings(max_examples=10)
@given(st.integers(0, 10_000), st.booleans())
def test_rays_meet_what_is_covered(seed: int, bent: bool) -> None:
    random = np.random.default_rng(seed)
    place = random.normal(size=3)
    place *= 4.0 / np.linalg.norm(place)
    lens = (-0.2, 0.05, 0.004, -0.003, 0.0) if bent else (0.0,) * 5
    camera = camera_at([float(one) for one in place], lens)
    mesh = trimesh.creation.torus(0.8, 0.3, major_sections=12, minor_sections=8)
    lines = rays(camera, pixel_centres(camera))
    met = mesh.ray.intersects_any(np.tile(camera.place(), (len(lines), 1)), lines)
    mask = silhouette(camera, surface_of(mesh))
    # The rays are single precision: one that runs along an edge may go either way.
    assert (mask != met.reshape(mask.shape)).sum() <= 1
    assert 100 < mask.sum() < mask.size


def test_what_lies_behind_or_beside_is_not_seen() -> None:
    box = trimesh.creation.box(extents=(1.0, 1.0, 1.0))
    behind = surface_of(box.copy().apply_translation([9.0, 0.0, 0.0]))
    beside = surface_of(box.copy().apply_translation([0.0, 9.0, 0.0]))
    for one in (behind, beside):
        assert not silhouette(camera_at([4.0, 0.0, 0.0]), one).any()


def test_overlap_counts_pixels() -> None:
    one, other = np.zeros((4, 4), bool), np.zeros((4, 4), bool)
    assert overlap(one, other) == 1.0
    one[:2], other[1:3] = True, True
    assert overlap(one, other) == pytest.approx(4 / 12)


def picture(inside: float, *, noise: float = 0.2, seed: int = 0) -> tuple[Frames, np.ndarray]:
    random = np.random.default_rng(seed)
    rows, columns = np.mgrid[:60, :80]
    truth = ((rows - 30) / 15) ** 2 + ((columns - 44) / 22) ** 2 < 1
    values = 293.0 + (inside - 293.0) * truth + noise * random.normal(size=(3, 60, 80))
    return Frames([0.0, 0.1, 0.2], values), truth


@pytest.mark.parametrize("inside", [296.0, 290.0])
def test_a_warm_and_a_cold_object_are_found(inside: float) -> None:
    frames, truth = picture(inside)
    assert overlap(mask_of(frames), truth) > 0.97


def test_values_that_are_missing_and_specks_are_no_object() -> None:
    frames, truth = picture(297.0)
    values = np.array(frames.values)
    values[:, 5:8, 5:8] = 298.0
    values[:, 30, 44] = np.nan
    found = mask_of(Frames(frames.time, values))
    assert not found[:10, :10].any()
    assert not found[30, 44]
    assert overlap(found, truth) > 0.97


@settings(max_examples=10)
@given(st.integers(0, 10_000))
def test_noise_holds_no_object(seed: int) -> None:
    with pytest.raises(InputError, match="cannot be told apart"):
        mask_of(picture(293.0, seed=seed)[0])


def test_a_slope_holds_no_object() -> None:
    values = np.broadcast_to(np.linspace(290.0, 300.0, 80), (1, 60, 80))
    with pytest.raises(InputError, match="4 deviations"):
        mask_of(Frames([0.0], values))


def test_empty_frames_are_refused() -> None:
    values = np.full((1, 20, 20), np.nan)
    values[0, 3, 3] = 300.0
    with pytest.raises(InputError, match="all but empty"):
        mask_of(Frames([0.0], values), where="film")
    with pytest.raises(InputError, match="cannot be told apart"):
        mask_of(Frames([0.0], np.full((1, 20, 20), 300.0)))


def test_pixels_that_are_never_read_are_the_background_of_rendered_frames() -> None:
    frames, truth = picture(297.0)
    random = np.random.default_rng(0)
    # No threshold could tell the object, of any temperature, from what is not there.
    values = np.where(truth, 290.0 + 20.0 * random.random(frames.values.shape), np.nan)
    assert np.array_equal(mask_of(Frames(frames.time, values)), truth)
