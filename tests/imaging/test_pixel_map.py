from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging import Camera, looking_at, pixel_centres, project, rays
from thermo.imaging._pixel_map import PixelMap, depth_at, look
from thermo.mesh import Surface

SQUARE = Surface(
    np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
)


def surface_of(mesh: trimesh.Trimesh) -> Surface:
    return Surface(np.asarray(mesh.vertices, float), np.asarray(mesh.faces))


def camera_at(place: list[float], size: tuple[int, int], focal: float, **more) -> Camera:
    width, height = size
    pose = looking_at(np.array(place, float), np.zeros(3), np.array([0.1, 0.2, 1.0]))
    return Camera(width, height, [focal] * 2, [(width - 1) / 2, (height - 1) / 2], pose, **more)


def positions(pixel_map: PixelMap, surface: Surface) -> np.ndarray:
    return np.einsum("hk,hki->hi", pixel_map.weights, surface.vertices[pixel_map.corners])


def test_a_square_from_straight_before_it() -> None:
    camera = camera_at([0.0, 0.0, 4.0], (31, 21), 40.0)
    seen = look(camera, SQUARE)
    # Half a side is 10 pixels at this distance: 21 by 21 pixels, turned by the camera's upright.
    assert seen.size() == (21, 31)
    np.testing.assert_allclose(seen.depth[10, 10:21], 4.0, rtol=1e-14)
    lines = rays(camera, pixel_centres(camera)).reshape(21, 31, 3)
    there = seen.triangle >= 0
    np.testing.assert_allclose(seen.cosine[there], -lines[there][:, 2], rtol=1e-13)
    assert np.isnan(seen.depth[~there]).all() and np.isnan(seen.cosine[~there]).all()
    assert (~there).any()
    at = positions(seen, SQUARE)
    assert np.abs(at[:, 2]).max() < 1e-15 and np.abs(at).max() <= 1.0
    hit = (seen.hit // 31, seen.hit % 31)
    assert (seen.triangle[hit] >= 0).all() and len(seen.hit) == there.sum()


def test_the_back_of_a_face_has_a_negative_cosine() -> None:
    seen = look(camera_at([0.0, 0.0, -4.0], (5, 5), 40.0), SQUARE)
    assert seen.cosine[2, 2] == pytest.approx(-1.0)


@given(
    place=st.tuples(*[st.floats(-1, 1)] * 2),
    lens=st.tuples(*[st.floats(-0.1, 0.1)] * 2, *[st.floats(-0.01, 0.01)] * 2),
)
def test_what_a_pixel_sees_is_projected_on_its_centre(
    place: tuple[float, float], lens: tuple[float, ...]
) -> None:
    ball = surface_of(trimesh.creation.icosphere(subdivisions=2, radius=0.05))
    camera = camera_at([place[0], place[1], 1.2], (24, 18), 180.0, distortion=[*lens, 0.0])
    seen = look(camera, ball)
    assert len(seen.hit) > 20
    pixels, depth = project(camera, positions(seen, ball))
    centres = pixel_centres(camera)[seen.hit]
    np.testing.assert_allclose(pixels, centres, atol=1e-9)
    np.testing.assert_allclose(depth, seen.depth.ravel()[seen.hit], rtol=1e-12)
    assert (seen.weights >= 0).all()
    np.testing.assert_allclose(seen.weights.sum(axis=1), 1.0, rtol=1e-14)
    assert (seen.cosine.ravel()[seen.hit] > 0).all()


def test_a_sphere_against_its_closed_form() -> None:
    radius, away, focal = 0.3, 1.5, 150.0
    ball = surface_of(trimesh.creation.icosphere(subdivisions=5, radius=radius))
    camera = camera_at([away * 0.6, 0.0, away * 0.8], (96, 80), focal)
    seen = look(camera, ball)
    # The cone that touches the sphere meets the picture in a circle.
    disc = np.pi * (focal * radius / np.sqrt(away**2 - radius**2)) ** 2
    assert len(seen.hit) == pytest.approx(disc, rel=0.01)
    lines = rays(camera, pixel_centres(camera))
    along = -(lines @ camera.place())
    inside = along**2 - away**2 + radius**2
    # Away from the silhouette; the facets lie within 0.04 % of the radius inside of the sphere.
    clear = np.flatnonzero(inside > 0.1 * radius**2)
    depth = (along - np.sqrt(np.maximum(inside, 0.0))) * (lines @ camera.pose[2, :3])
    off = seen.depth.ravel()[clear] - depth[clear]
    assert len(clear) > 0.8 * disc
    assert (off > -1e-12).all() and off.max() < 2e-3 * radius


def all_crossings(surface: Surface, start: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Distances to the first triangle by solving for every one: no search, no tolerance."""
    nearest = np.full(len(lines), np.inf)
    for triangle in surface.triangles:
        a, b, c = surface.vertices[triangle]
        matrix = np.stack([np.stack([b - a, c - a, -line], axis=1) for line in lines])
        u, v, t = np.linalg.solve(matrix, np.broadcast_to(start - a, (len(lines), 3))[..., None]).T[
            0
        ]
        met = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
        nearest = np.where(met, np.minimum(nearest, t), nearest)
    return nearest


def test_a_torus_against_all_its_triangles() -> None:
    ring = surface_of(trimesh.creation.torus(0.06, 0.025, major_sections=16, minor_sections=10))
    camera = camera_at([0.05, 0.13, 0.11], (32, 24), 28.0)
    lines = rays(camera, pixel_centres(camera))
    exact = all_crossings(ring, camera.place(), lines)
    seen = look(camera, ring)
    depth = exact * (lines @ camera.pose[2, :3])
    np.testing.assert_array_equal(np.isfinite(exact), (seen.triangle >= 0).ravel())
    assert 100 < len(seen.hit) < 700
    np.testing.assert_allclose(seen.depth.ravel()[seen.hit], depth[seen.hit], rtol=1e-12)


def test_no_ray_slips_through_an_edge() -> None:
    # Rays through the diagonals of the front, which lie before those of the back.
    box = surface_of(trimesh.creation.box([2.0, 2.0, 2.0]))
    pose = looking_at(np.array([0.0, 0.0, 5.0]), np.zeros(3), np.array([0.0, 1.0, 0.0]))
    camera = Camera(33, 33, [60.0, 60.0], [16.0, 16.0], pose)
    seen = look(camera, box)
    front = np.abs(pixel_centres(camera) - 16.0).max(axis=1) <= 14
    np.testing.assert_allclose(seen.depth.ravel()[front], 4.0, rtol=1e-12)


@pytest.mark.parametrize(("scale", "shift"), [(1e-3, 0.0), (1.0, 1e4), (1e3, 0.0)])
def test_size_and_place_do_not_matter(scale: float, shift: float) -> None:
    ball = surface_of(trimesh.creation.icosphere(subdivisions=3))
    camera = camera_at([3.0, 40.0, 2.0], (40, 30), 700.0)
    first = look(camera, ball)
    move = np.array([shift, -shift, shift])
    pose = camera.pose.copy()
    pose[:3, 3] = pose[:3, 3] * scale - pose[:3, :3] @ move
    moved = Surface(ball.vertices * scale + move, ball.triangles)
    other = look(Camera(40, 30, camera.focal, camera.centre, pose), moved)
    np.testing.assert_array_equal(first.triangle, other.triangle)
    np.testing.assert_allclose(first.depth * scale, other.depth, rtol=1e-9)


def test_a_camera_that_looks_away_sees_nothing() -> None:
    pose = looking_at(np.array([0.0, 0, 4]), np.array([0.0, 0, 8]), np.array([0.0, 1, 0]))
    seen = look(Camera(8, 6, [9.0, 9.0], [3.5, 2.5], pose), SQUARE)
    assert (seen.triangle == -1).all() and len(seen.hit) == 0 and seen.weights.shape == (0, 3)


def test_surfaces_that_cannot_be_looked_at() -> None:
    camera = camera_at([0.0, 0.0, 4.0], (5, 5), 40.0)
    with pytest.raises(InputError, match="at least one triangle"):
        look(camera, Surface(SQUARE.vertices, np.zeros((0, 3), int)))
    with pytest.raises(InputError, match="finite"):
        look(camera, Surface(SQUARE.vertices * np.nan, SQUARE.triangles))


def test_depth_is_read_at_the_nearest_pixel() -> None:
    seen = look(camera_at([0.0, 0.0, 4.0], (31, 21), 40.0), SQUARE)
    asked = np.array(
        [[15.4, 9.6], [15.0, 10.0], [-0.6, 3.0], [30.6, 3.0], [np.nan, 1.0], [0.0, 0.0]]
    )
    found = depth_at(seen, asked)
    np.testing.assert_allclose(found[:2], seen.depth[10, 15])
    assert np.isnan(found[2:]).all()
    assert depth_at(seen, np.array([[-0.5, 20.4]]))[0] == pytest.approx(
        seen.depth[20, 0], nan_ok=True
    )
