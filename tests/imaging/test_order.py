"""Recordings that stand in another order than their cameras."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from cameras import camera_at

from thermo.imaging import (
    Camera,
    Frames,
    better_order,
    contours_apart,
    looks_of,
    silhouette,
    similarity_about,
)
from thermo.mesh import Surface


def surface_of(mesh: trimesh.Trimesh) -> Surface:
    return Surface(np.asarray(mesh.vertices), np.asarray(mesh.faces, dtype=np.int64))


BRICK = surface_of(trimesh.creation.box([0.06, 0.08, 0.03]))
BALL = surface_of(trimesh.creation.icosphere(subdivisions=3, radius=0.04))
CAMERAS = [
    camera_at((0.4, 0.1, 0.1), focal=150.0, name="front"),
    camera_at((0.1, 0.4, 0.2), focal=150.0, name="side"),
    camera_at((0.05, 0.0, 0.4), focal=150.0, name="top"),
]


def film(camera: Camera, surface: Surface, *, room: float = 290.0, seed: int = 0) -> Frames:
    """A warm object before a colder room, with noise."""
    mask = silhouette(camera, surface)
    noise = 0.05 * np.random.default_rng(seed).standard_normal((2, *mask.shape))
    return Frames([0.0, 1.0], np.where(mask, 300.0, room) + noise)


def films(surface: Surface) -> list[Frames]:
    return [film(one, surface, seed=number) for number, one in enumerate(CAMERAS)]


@pytest.mark.parametrize(
    ("given", "better"),
    [((0, 1, 2), None), ((1, 0, 2), (1, 0, 2)), ((0, 2, 1), (0, 2, 1)), ((1, 2, 0), (2, 0, 1))],
)
def test_recordings_in_another_order_are_found(
    given: tuple[int, ...], better: tuple[int, ...] | None
) -> None:
    right = films(BRICK)
    assert better_order(looks_of(BRICK, CAMERAS), [right[one] for one in given]) == better


@pytest.mark.parametrize("seed", range(12))
def test_a_surface_out_of_place_is_no_other_order(seed: int) -> None:
    random = np.random.default_rng(seed)
    motion = np.zeros(7)
    motion[:3] = np.radians(12.0) * random.normal(size=3)
    motion[3:6] = 0.006 * random.normal(size=3)
    moved = similarity_about(np.zeros(3), motion).apply(BRICK.vertices)
    right = films(Surface(moved, BRICK.triangles))
    assert better_order(looks_of(BRICK, CAMERAS), right) is None


def test_what_looks_alike_from_all_sides_has_no_order() -> None:
    right = films(BALL)
    assert better_order(looks_of(BALL, CAMERAS), right[::-1]) is None


def test_only_the_cameras_whose_order_is_clear_are_named() -> None:
    # Two of four cameras stand in one place: their recordings could be exchanged unseen.
    again = camera_at((0.05, 0.0, 0.4), focal=150.0, name="again")
    cameras = [*CAMERAS, again]
    right = [*films(BRICK), film(again, BRICK, seed=9)]
    swapped = [right[1], right[0], right[3], right[2]]
    assert better_order(looks_of(BRICK, cameras), swapped) == (1, 0, 2, 3)


def test_warm_spots_within_all_silhouettes_tell_no_order() -> None:
    spots = []
    for number, size in enumerate((2, 5, 8)):
        values = np.full((1, 48, 64), 290.0)
        values[:, 24 - size : 24 + size, 32 - size : 32 + size] = 300.0
        spots.append(Frames([0.0], values + 0.01 * number))
    assert better_order(looks_of(BRICK, CAMERAS), spots) is None


def test_without_an_object_that_stands_out_nothing_is_said() -> None:
    right = films(BRICK)
    swapped = [right[1], right[0], film(CAMERAS[2], BRICK, room=300.0)]
    assert better_order(looks_of(BRICK, CAMERAS), swapped) is None


def test_frames_of_another_size_are_not_exchanged() -> None:
    wide = camera_at((0.1, 0.4, 0.2), size=(80, 48), focal=150.0, name="wide")
    cameras = [CAMERAS[0], wide]
    right = [film(one, BRICK) for one in cameras]
    assert better_order(looks_of(BRICK, cameras), right) is None


def test_contours_lie_apart_by_what_a_surface_is_moved() -> None:
    there = contours_apart(looks_of(BRICK, CAMERAS), films(BRICK))
    assert there is not None and there.shape == (3,) and there.max() < 0.5
    # The camera above sees 12 mm at 0.4 m through 150 px: 4.5 px on two of four sides, gained or
    # lost, which over all of its outline is half of that to all of it.
    shift = similarity_about(np.zeros(3), np.array([0, 0, 0, 0.012, 0, 0, 0]))
    moved = Surface(shift.apply(BRICK.vertices), BRICK.triangles)
    apart = contours_apart(looks_of(moved, CAMERAS), films(BRICK))
    assert apart is not None and 2.0 < apart[2] < 5.0
    blank = [Frames([0.0, 1.0], np.full_like(film(CAMERAS[0], BRICK).values, 290.0))]
    assert contours_apart(looks_of(BRICK, CAMERAS[:1]), blank) is None
