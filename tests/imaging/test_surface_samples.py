"""Places that cameras read."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from cameras import camera_at

from thermo.errors import InputError
from thermo.imaging import Camera, looks_of, place_samples, project
from thermo.imaging._surface_samples import _spread
from thermo.mesh import Surface

RADIUS = 0.05


def surface_of(mesh: trimesh.Trimesh) -> Surface:
    return Surface(np.asarray(mesh.vertices), np.asarray(mesh.faces, dtype=np.int64))


BALL = surface_of(trimesh.creation.icosphere(subdivisions=4, radius=RADIUS))
CAMERAS = [
    camera_at((0.3, 0.0, 0.1), size=(80, 60), focal=150.0, name="front"),
    camera_at((0.15, 0.3, 0.0), size=(60, 60), focal=120.0, name="side"),
]


def test_samples_lie_where_cameras_read_them() -> None:
    samples = place_samples(looks_of(BALL, CAMERAS), count=150)
    assert len(samples.points) == 150 and samples.seen.any(axis=0).all()
    assert samples.seen.sum(axis=1).min() > 40 and samples.seen.all(axis=0).any()
    np.testing.assert_allclose(samples.weights.sum(axis=2), 1.0, atol=1e-8)
    for number, camera in enumerate(CAMERAS):
        seen = samples.seen[number]
        towards = camera.place() - samples.points
        outward = np.einsum("ij,ij->i", towards, samples.points) > 0
        assert outward[seen].all()
        # The four pixels and their weights give the sample's own place in the frame.
        pixels = samples.pixels[number, seen]
        place = np.stack([pixels % camera.width, pixels // camera.width], -1)
        mean = np.einsum("sk,ski->si", samples.weights[number, seen], place)
        np.testing.assert_allclose(mean, project(camera, samples.points[seen])[0], atol=1e-6)
        assert np.isnan(samples.footprint[number, ~seen]).all()
        assert (samples.cosine[number, seen] > np.cos(np.radians(70.0)) - 1e-9).all()


def test_samples_are_spread_evenly() -> None:
    samples = place_samples(looks_of(BALL, CAMERAS[:1]), count=100)
    apart = np.linalg.norm(samples.points[:, None] - samples.points[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    nearest = apart.min(axis=1)
    assert nearest.min() > 0.6 * np.median(nearest)


@pytest.mark.parametrize("seed", range(4))
def test_each_next_place_is_the_farthest_from_all_before(seed: int) -> None:
    places = np.random.default_rng(seed).normal(size=(400, 3)) * [1.0, 0.5, 0.1]
    places[:40] = places[40:80]
    picked = _spread(places, 500)
    # Copies are never taken: 360 different places are all that there are.
    assert len(picked) == 360
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)
    for number in range(1, 200):
        away = apart[:, picked[:number]].min(axis=1)
        assert away[picked[number]] == away.max()


def test_fewer_are_placed_where_few_pixels_look() -> None:
    small = camera_at((0.3, 0.0, 0.0), size=(12, 10), focal=20.0)
    samples = place_samples(looks_of(BALL, [small], margin=1), count=500)
    assert 1 <= len(samples.points) < 40


def test_a_camera_that_looks_away_is_told_of_with_the_way_out() -> None:
    fine = CAMERAS[0]
    turned = Camera(
        80, 60, fine.focal, fine.centre, np.diag([1.0, -1.0, -1.0, 1.0]) @ fine.pose, name="other"
    )
    with pytest.raises(InputError, match="other convention") as caught:
        looks_of(BALL, [fine, turned], where="poses.json")
    assert "poses.json: other" in str(caught.value) and "behind it" in str(caught.value)
    aside = Camera(80, 60, fine.focal, fine.centre - 1000.0, fine.pose)
    with pytest.raises(InputError, match="one world and one unit"):
        looks_of(BALL, [aside])
    # What brings the world to the camera, taken for what brings the camera to the world.
    back = Camera(80, 60, fine.focal, fine.centre, np.linalg.inv(fine.pose))
    with pytest.raises(InputError, match="matrices inverted"):
        looks_of(BALL, [back])
    far = camera_at((300.0, 0.0, 100.0), size=(80, 60), focal=150.0)
    with pytest.raises(InputError, match="camera_scale=0.001"):
        looks_of(BALL, [far])


def test_pixels_at_edges_alone_are_no_samples() -> None:
    far = camera_at((3.0, 0.0, 0.0), size=(20, 20), focal=80.0)
    with pytest.raises(InputError, match="grazing angles or at an edge"):
        looks_of(BALL, [far])
    with pytest.raises(InputError, match="samples"):
        place_samples(looks_of(BALL, CAMERAS), count=0)
