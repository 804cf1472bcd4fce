from __future__ import annotations

import numpy as np
import pytest
import trimesh

from thermo.errors import InputError
from thermo.imaging import Camera, looking_at, pixel_centres, rays
from thermo.imaging._pixel_map import look
from thermo.imaging._render import render
from thermo.mesh import Surface

POSE = looking_at(np.array([0.3, -0.2, 3.0]), np.zeros(3), np.array([0.2, 1.0, 0.0]))
CAMERA = Camera(40, 30, [60.0, 58.0], [19.0, 15.0], POSE, [0.05, -0.02, 1e-3, 2e-3, 0.0])


def plate() -> Surface:
    """A square in 128 triangles of random shape, in the plane z = 0."""
    line = np.linspace(-1.0, 1.0, 9)
    x, y = np.meshgrid(line, line)
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(81)])
    inner = np.abs(vertices[:, :2]).max(axis=1) < 0.99
    vertices[inner, :2] += np.random.default_rng(0).uniform(-0.08, 0.08, (inner.sum(), 2))
    a = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + 10], 1), np.stack([a, a + 10, a + 9], 1)])
    return Surface(vertices, faces)


def test_a_linear_field_is_exact() -> None:
    surface = plate()
    slope, level = np.array([7.0, -11.0]), 300.0
    picture = render(look(CAMERA, surface), level + surface.vertices[:, :2] @ slope)
    lines = rays(CAMERA, pixel_centres(CAMERA))
    place = CAMERA.place()
    flat = (place - lines * (place[2] / lines[:, 2])[:, None])[:, :2]
    inside = (np.abs(flat) < 1 - 1e-9).all(axis=1).reshape(30, 40)
    wanted = (level + flat @ slope).reshape(30, 40)
    np.testing.assert_allclose(picture[inside], wanted[inside], rtol=1e-14)
    assert inside.sum() > 500 and np.isnan(picture[~inside]).all() and (~inside).any()


def test_a_picture_stays_within_its_values() -> None:
    ball = trimesh.creation.icosphere(subdivisions=2)
    surface = Surface(np.asarray(ball.vertices, float), np.asarray(ball.faces))
    pixel_map = look(CAMERA, surface)
    for row in np.random.default_rng(1).uniform(290.0, 310.0, (4, len(surface.vertices))):
        frame = render(pixel_map, row)
        assert np.nanmin(frame) >= row.min() and np.nanmax(frame) <= row.max()


def test_values_of_another_surface_are_refused() -> None:
    pixel_map = look(CAMERA, plate())
    with pytest.raises(InputError, match="81 vertices, as was looked at"):
        render(pixel_map, np.zeros(80))
