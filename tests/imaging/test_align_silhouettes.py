"""Poses from silhouettes: recovery, what silhouettes do not tell, and failures."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from thermo.errors import InputError
from thermo.imaging import Camera, looking_at
from thermo.imaging._align_silhouettes import Alignment, align_to_silhouettes
from thermo.imaging._silhouette import silhouette
from thermo.imaging._similarity import Similarity, motion_about, similarity_about
from thermo.mesh import Surface

VIEWS = ((10, 20), (100, 45), (205, 5), (290, -30))  # deg


def surface_of(mesh: trimesh.Trimesh) -> Surface:
    return Surface(np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64))


def lump() -> Surface:
    """A ball drawn out of shape, so that no turn brings it onto itself."""
    ball = surface_of(trimesh.creation.icosphere(subdivisions=3, radius=0.03))
    x, y, z = ball.vertices.T
    bent = np.stack([1.5 * x + 0.008 * np.sin(80 * y), y, 0.8 * z + 0.012 * np.cos(50 * x)], 1)
    return Surface(bent, ball.triangles)


def cameras_around(size: float, count: int = 4) -> list[Camera]:
    found = []
    for number, (azimuth, elevation) in enumerate(np.radians(VIEWS)[:count]):
        flat = np.cos(elevation)
        way = np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])
        pose = looking_at(3 * size * way, np.zeros(3), np.array([0.0, 0.0, 1.0]))
        found.append(Camera(80, 60, (150, 150), (39.5, 29.5), pose, name=f"view {number}"))
    return found


def start(surface: Surface, seed: int, *, scale: bool, truth: Similarity) -> Similarity:
    """Away by 5 degrees, 3 % of the size and 2 % in scale."""
    random = np.random.default_rng(seed)
    ways = random.normal(size=(2, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    motion = np.zeros(7)
    motion[:3] = np.radians(5.0) * ways[0]
    motion[3:6] = 0.03 * surface.diagonal() * ways[1]
    motion[6] = 0.02 * scale
    return similarity_about(truth.apply(np.zeros((1, 3)))[0], motion).after(truth)


def align(
    surface: Surface, count: int = 4, *, scale: bool = True, seed: int = 0
) -> tuple[Alignment, np.ndarray]:
    """The fit and what is left of the pose."""
    truth = similarity_about(np.zeros(3), np.array([0.4, -0.3, 0.2, 0.002, 0.001, -0.002, 0.0]))
    placed = Surface(truth.apply(surface.vertices), surface.triangles)
    cameras = cameras_around(surface.diagonal(), count)
    masks = [silhouette(camera, placed) for camera in cameras]
    guess = start(surface, seed, scale=scale, truth=truth)
    found = align_to_silhouettes(surface, cameras, masks, guess, scale=scale)
    middle = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
    there = truth.apply(middle[None])[0]
    return found, motion_about(there, found.similarity.after(truth.inverse()))


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("scale", [True, False])
def test_the_pose_of_a_lump_is_found(seed: int, scale: bool) -> None:
    surface = lump()
    found, left = align(surface, scale=scale, seed=seed)
    assert found.success, found.reason
    assert np.degrees(np.linalg.norm(left[:3])) < 0.5
    assert np.linalg.norm(left[3:6]) < 0.01 * surface.diagonal()
    assert abs(left[6]) < (0.01 if scale else 1e-12)
    assert found.untold == ()
    assert (found.overlap_before < 0.95).all() and (found.overlap_after > 0.98).all()
    assert found.residual < 0.5
    free = 7 if scale else 6
    assert (np.abs(left[:free]) < 5 * found.deviation[:free]).all()
    assert (found.deviation[6] == 0) == (not scale)


def test_a_box_is_found_too() -> None:
    box = surface_of(trimesh.creation.box(extents=(0.06, 0.04, 0.03)))
    found, left = align(box)
    assert found.success and found.untold == ()
    assert np.degrees(np.linalg.norm(left[:3])) < 0.5


def test_a_ball_turns_unseen() -> None:
    ball = surface_of(trimesh.creation.icosphere(subdivisions=4, radius=0.03))
    found, left = align(ball)
    assert len(found.untold) == 3
    assert all(words.startswith("rotation about") for words in found.untold)
    assert (found.deviation[:3] > 1.0).all()
    assert (found.deviation[3:6] < 0.01 * ball.diagonal()).all() and found.deviation[6] < 0.01
    assert np.linalg.norm(left[3:6]) < 0.002 * ball.diagonal()
    assert found.success, found.reason


def test_a_cylinder_turns_unseen_about_its_axis() -> None:
    rod = surface_of(trimesh.creation.cylinder(radius=0.02, height=0.07, sections=64))
    placed = Surface(rod.vertices, rod.triangles)
    cameras = cameras_around(rod.diagonal())
    masks = [silhouette(camera, placed) for camera in cameras]
    motion = np.array([0.05, -0.04, 0.06, 0.001, 0.002, -0.001, 0.0])
    found = align_to_silhouettes(rod, cameras, masks, similarity_about(np.zeros(3), motion))
    assert found.untold == ("rotation about [0, 0, 1]",)
    assert found.success, found.reason
    assert found.deviation[2] > 1.0 and (found.deviation[:2] < np.radians(1.0)).all()
    axis = found.similarity.rotation[:, 2]
    assert np.degrees(np.arccos(min(1.0, abs(axis[2])))) < 0.5


def test_one_camera_does_not_tell_scale_from_distance() -> None:
    box = surface_of(trimesh.creation.box(extents=(0.06, 0.04, 0.03)))
    found, _ = align(box, 1)
    assert "scale and distance together" in found.untold
    assert found.deviation[6] > 0.1
    alone, left = align(box, 1, scale=False)
    assert alone.untold == ()
    assert np.linalg.norm(left[3:6]) < 0.03 * box.diagonal()
    assert (np.abs(left[3:6]) < 5 * alone.deviation[3:6]).all()


def test_masks_of_another_object_fail() -> None:
    surface, cameras = lump(), cameras_around(lump().diagonal())
    other = surface_of(trimesh.creation.box(extents=(0.08, 0.02, 0.05)))
    masks = [silhouette(camera, other) for camera in cameras]
    found = align_to_silhouettes(surface, cameras, masks, scale=True)
    assert not found.success
    assert found.reason


def test_a_mask_with_a_part_missing_fails_there() -> None:
    surface, cameras = lump(), cameras_around(lump().diagonal())
    masks = [silhouette(camera, surface) for camera in cameras]
    masks[2][:28] = False
    found = align_to_silhouettes(surface, cameras, masks)
    assert not found.success
    assert "view 2" in found.reason
    assert found.overlap_after[[0, 1, 3]].min() > 0.9 > found.overlap_after[2]


def test_objects_out_of_view_are_refused() -> None:
    surface, cameras = lump(), cameras_around(lump().diagonal())
    masks = [silhouette(camera, surface) for camera in cameras]
    away = Similarity(shift=[0.0, 0.0, 5.0])
    with pytest.raises(InputError, match="out of view"):
        align_to_silhouettes(surface, cameras, masks, away)


def test_masks_that_do_not_fit_are_refused() -> None:
    surface, cameras = lump(), cameras_around(lump().diagonal())
    masks = [silhouette(camera, surface) for camera in cameras]
    with pytest.raises(InputError, match="differ in number"):
        align_to_silhouettes(surface, cameras, masks[:3])
    with pytest.raises(InputError, match="rows first"):
        align_to_silhouettes(surface, cameras, [*masks[:3], masks[3].T.copy()])
    for empty in (np.zeros((60, 80), bool), np.ones((60, 80), bool)):
        with pytest.raises(InputError, match="no contour") as caught:
            align_to_silhouettes(surface, cameras, [*masks[:3], empty])
        assert "view 3" in str(caught.value)
    with pytest.raises(InputError, match="above 0"):
        align_to_silhouettes(surface, cameras, masks, contour_error=0.0)
