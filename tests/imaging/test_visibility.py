from __future__ import annotations

import numpy as np
import pytest
import trimesh

from thermo.errors import InputError
from thermo.imaging import Camera, looking_at
from thermo.imaging._pixel_map import look
from thermo.imaging._visibility import depth_tolerance, seen_by_depth, seen_exactly
from thermo.mesh import Surface


def surface_of(mesh: trimesh.Trimesh) -> Surface:
    return Surface(np.asarray(mesh.vertices, float), np.asarray(mesh.faces))


def camera_at(place: np.ndarray, size: tuple[int, int] = (160, 120)) -> Camera:
    width, height = size
    pose = looking_at(place, np.zeros(3), np.array([0.1, 0.2, 1.0]))
    return Camera(width, height, [width] * 2, [(width - 1) / 2, (height - 1) / 2], pose)


def ring_and_comb() -> list[trimesh.Trimesh]:
    """A torus, and six blades of 4 mm with gaps of 8 mm above a plate."""
    parts = [trimesh.creation.box([0.068, 0.06, 0.01])]
    parts[0].apply_translation([0.0, 0.0, -0.0315])
    for number in range(6):
        parts.append(trimesh.creation.box([0.004, 0.06, 0.05]))
        parts[-1].apply_translation([0.012 * number - 0.03, 0.0, 0.0])
    ring = trimesh.creation.torus(0.05, 0.02, major_sections=48, minor_sections=24)
    return [ring, trimesh.util.concatenate(parts)]


BODIES = ring_and_comb()
PLACES = np.array([[0.1, 0.05, 0.12], [0.16, 0.0, 0.02], [-0.05, 0.12, -0.09]])


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("body", BODIES, ids=["ring", "comb"])
def test_the_depth_rule_keeps_little_that_is_hidden(
    body: trimesh.Trimesh, place: np.ndarray
) -> None:
    surface, camera = surface_of(body), camera_at(place, (240, 180))
    points = np.asarray(trimesh.sample.sample_surface(body, 2000, seed=1)[0])
    exact = seen_exactly(camera, surface, points)
    kept = seen_by_depth(look(camera, surface), camera, surface, points)
    assert 120 < exact.sum() < 1000
    assert (kept & ~exact).sum() < 0.01 * kept.sum()
    assert (exact & ~kept).sum() < 0.25 * exact.sum()


def test_a_wide_tolerance_keeps_what_is_hidden() -> None:
    comb, camera = surface_of(BODIES[1]), camera_at(PLACES[0], (240, 180))
    points = np.asarray(trimesh.sample.sample_surface(BODIES[1], 2000, seed=1)[0])
    exact, pixel_map = seen_exactly(camera, comb, points), look(camera, comb)
    wide = seen_by_depth(pixel_map, camera, comb, points, tolerance=0.01)
    assert (wide & ~exact).sum() > 0.01 * wide.sum()


def two_plates() -> Surface:
    """A small plate at z = 1 before a large one at z = 0, both 0.02 thick."""
    near = trimesh.creation.box([1.0, 1.0, 0.02])
    near.apply_translation([0, 0, 1.0])
    far = trimesh.creation.box([4.0, 4.0, 0.02])
    far.apply_translation([0, 0, -0.01])
    return surface_of(trimesh.util.concatenate([near, far]))


def test_the_shadow_of_a_plate_against_its_closed_form() -> None:
    plates, place = two_plates(), np.array([0.2, -0.1, 3.0])
    camera = Camera(
        200, 200, [150.0, 150.0], [99.5, 99.5],
        looking_at(place, np.array([0.2, -0.1, 0.0]), np.array([0.0, 1.0, 0.0])),
    )  # fmt: skip
    drawn = np.random.default_rng(2).uniform(-1.6, 1.6, (600, 2))
    points = np.column_stack([drawn, np.zeros(600)])
    # A point is hidden where its line to the camera passes the upper or lower side of the plate.
    hidden = np.zeros(600, bool)
    for height in np.linspace(0.99, 1.01, 21):
        share = height / place[2]
        hidden |= (np.abs(drawn * (1 - share) + place[:2] * share) <= 0.5).all(axis=1)
    exact = seen_exactly(camera, plates, points)
    np.testing.assert_array_equal(exact, ~hidden)
    kept = seen_by_depth(look(camera, plates), camera, plates, points)
    assert not (kept & hidden).any()
    assert kept.sum() > 0.95 * exact.sum()
    assert 100 < hidden.sum() < 400


def test_a_great_tolerance_keeps_all_that_is_framed_and_turned_to_the_camera() -> None:
    plates, place = two_plates(), np.array([0.0, 0.0, 3.0])
    camera = camera_at(place)
    points = np.array([[0.1, 0.1, 0.0], [0.1, 0.1, 1.01]])
    pixel_map = look(camera, plates)
    assert seen_by_depth(pixel_map, camera, plates, points).tolist() == [False, True]
    wide = seen_by_depth(pixel_map, camera, plates, points, tolerance=1.1)
    assert wide.tolist() == [True, True]


def test_what_is_never_seen() -> None:
    plates, place = two_plates(), np.array([0.0, 0.0, 3.0])
    camera = camera_at(place)
    points = np.array([[0.1, 0.1, -0.02], [1.99, 1.99, 0.0], [0.1, 0.1, 1.01]])
    away = looking_at(place, np.array([0.0, 0, 9.0]), np.array([0.0, 1.0, 0.0]))
    turned = Camera(160, 120, [160.0, 160.0], [79.5, 59.5], away)
    for one, wanted in ((camera, [False, False, True]), (turned, [False] * 3)):
        assert seen_exactly(one, plates, points).tolist() == wanted
        assert seen_by_depth(look(one, plates), one, plates, points).tolist() == wanted
    normals = np.array([[0.0, 0, -1.0]] * 3)
    assert not seen_exactly(camera, plates, points, normals=normals).any()
    assert not seen_by_depth(look(camera, plates), camera, plates, points, normals=normals).any()


def test_a_point_off_the_surface_stands_for_the_nearest_on_it() -> None:
    plates = two_plates()
    camera = camera_at(np.array([0.0, 0.0, 3.0]))
    below = np.array([[0.1, 0.1, 1.007]])  # inside of the upper plate
    assert seen_exactly(camera, plates, below).all()
    assert seen_by_depth(look(camera, plates), camera, plates, below).all()


def test_the_tolerance_is_what_a_plane_changes_over_a_pixel() -> None:
    camera = Camera(200, 200, [500.0, 400.0], [99.5, 99.5], np.eye(4))
    for normal in ([0.3, 0.0, -1.0], [0.2, -0.5, -0.8]):
        n, point = np.array(normal), np.array([0.02, -0.03, 0.7])
        ray = point / point[2]
        steps = np.array([[dx / 500.0, dy / 400.0, 0.0] for dx in (-1, 1) for dy in (-1, 1)])
        depths = (n @ point) / ((ray + steps) @ n)
        largest = np.abs(depths - 0.7).max()
        eps = depth_tolerance(camera, point[None], n[None])[0]
        assert eps == pytest.approx(largest, rel=0.01)
    steep = depth_tolerance(camera, np.array([[0.0, 0, 1]]), np.array([[1.0, 0, -1e-4]]))[0]
    assert steep == pytest.approx(1 / 500 / 0.25, rel=1e-3)


def test_maps_of_other_views_and_empty_tolerances_are_refused() -> None:
    plates, camera = two_plates(), camera_at(np.array([0.0, 0.0, 3.0]))
    other = look(camera_at(np.array([0.0, 0.0, 3.0]), (80, 60)), plates)
    points = np.zeros((1, 3))
    with pytest.raises(InputError, match="another view"):
        seen_by_depth(other, camera, plates, points)
    with pytest.raises(InputError, match="depth tolerance"):
        seen_by_depth(look(camera, plates), camera, plates, points, tolerance=0.0)
    with pytest.raises(InputError, match="not finite"):
        seen_exactly(camera, plates, points * np.nan)
