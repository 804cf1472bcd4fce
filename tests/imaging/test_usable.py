"""Which pixels tell the temperature of one place."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from cameras import camera_at

from thermo.errors import InputError
from thermo.imaging import Camera
from thermo.imaging._pixel_map import look
from thermo.imaging._usable import footprint, places_of, usable_pixels
from thermo.mesh import Surface

RADIUS = 0.05


def surface_of(mesh: trimesh.Trimesh) -> Surface:
    return Surface(np.asarray(mesh.vertices), np.asarray(mesh.faces, dtype=np.int64))


def ball() -> tuple[Camera, Surface]:
    sphere = surface_of(trimesh.creation.icosphere(subdivisions=4, radius=RADIUS))
    return camera_at((0.3, 0.0, 0.0), size=(80, 60), focal=150.0), sphere


def test_the_footprints_of_all_pixels_cover_what_is_seen() -> None:
    camera, sphere = ball()
    seen = look(camera, sphere)
    # Before the rim, where a pixel's footprint is no square: a cap of 60 degrees about its normal.
    within = seen.cosine > 0.5
    area = float(np.sum(footprint(camera, seen)[within] ** 2))
    # On a sphere seen from d the angle at its centre is theta minus the angle at the eye.
    theta = np.radians(60.0)
    polar = theta - np.arcsin(RADIUS / 0.3 * np.sin(theta))
    cap = 2 * np.pi * RADIUS**2 * (1 - np.cos(polar))
    assert area == pytest.approx(cap, rel=0.05)


def test_grazing_and_rim_pixels_are_left_out() -> None:
    camera, sphere = ball()
    seen = look(camera, sphere)
    usable = usable_pixels(camera, sphere, seen, grazing=60.0, margin=1)
    assert usable.any() and (seen.cosine[usable] > 0.5).all()
    whole = usable_pixels(camera, sphere, seen, grazing=89.0, margin=0)
    assert whole.sum() > usable.sum()
    # The margin alone: with every angle allowed, no pixel has background beside it.
    rim = usable_pixels(camera, sphere, seen, grazing=89.0, margin=2)
    rows, columns = np.nonzero(rim)
    for down in (-2, 0, 2):
        for across in (-2, 0, 2):
            assert (seen.triangle[rows + down, columns + across] >= 0).all()


def test_an_edge_within_the_object_is_left_out() -> None:
    # A small box before a large one, seen from straight ahead.
    back = trimesh.creation.box([0.01, 0.2, 0.2])
    front = trimesh.creation.box([0.01, 0.06, 0.06])
    front.apply_translation([0.1, 0.0, 0.0])
    both = surface_of(trimesh.util.concatenate([back, front]))
    camera = camera_at((0.5, 0.0, 0.0), size=(80, 60), focal=120.0)
    seen = look(camera, both)
    usable = usable_pixels(camera, both, seen, margin=1)
    depth = seen.depth
    jump = np.zeros_like(usable)
    jump[:, 1:] |= np.abs(np.diff(depth, axis=1)) > 0.05
    jump[:, :-1] |= np.abs(np.diff(depth, axis=1)) > 0.05
    assert jump.any() and not (usable & jump).any()
    assert usable[30, 40] and seen.depth[30, 40] == pytest.approx(0.395, abs=1e-6)


def test_places_lie_on_the_surface() -> None:
    camera, sphere = ball()
    seen = look(camera, sphere)
    places = places_of(sphere, seen)
    assert np.isnan(places[seen.triangle < 0]).all()
    radii = np.linalg.norm(places[seen.triangle >= 0], axis=1)
    assert radii.max() <= RADIUS + 1e-12 and radii.min() > 0.995 * RADIUS


@pytest.mark.parametrize("wrong", [{"grazing": 95.0}, {"grazing": 0.0}, {"margin": -1}])
def test_limits_that_make_no_sense_are_refused(wrong: dict) -> None:
    camera, sphere = ball()
    with pytest.raises(InputError, match=next(iter(wrong))):
        usable_pixels(camera, sphere, look(camera, sphere), **wrong)
