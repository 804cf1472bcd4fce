"""What is found before training, on photographs of a ball that each have one fault."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
from tests.support.coloured_ball import CENTRE, RADIUS, cameras, photograph

from thermo.imaging import Camera
from thermo.reconstruct import Finding, Photograph, Region, preflight, region_of


@cache
def photographs() -> tuple[Photograph, ...]:
    return tuple(photograph(camera) for camera in cameras(14))


@cache
def seen() -> Region:
    """Where the photographs, none of them with a fault, show the ball."""
    return region_of(photographs())


def with_first(**changed: object) -> tuple[Photograph, ...]:
    first, *rest = photographs()
    return (dataclasses.replace(first, **changed), *rest)


def posed(camera: Camera, pose: np.ndarray) -> Camera:
    return Camera(camera.width, camera.height, camera.focal, camera.centre, pose, name=camera.name)


def words(findings: tuple[Finding, ...]) -> str:
    return "\n".join(f"{one.where}: {one.what}" for one in findings)


def test_good_photographs_are_found_good() -> None:
    region = seen()
    # But for their size, 19 pixels across, which is told of each.
    found = preflight(photographs(), region)
    assert {one.what for one in found} == {"the object is 19 pixels across"}
    assert len(found) == 14
    assert np.abs(region.centre - CENTRE).max() < 0.2 * RADIUS
    assert RADIUS < region.half < 1.5 * RADIUS


@pytest.mark.parametrize(
    ("mask", "said", "fatal"),
    [
        (lambda mask: 0 * mask, "shows no object", True),
        (lambda mask: 1 - mask, "covers most of the picture's edge", True),
        (lambda mask: np.roll(mask, 15, axis=0), "edge cuts the object", False),
        (lambda mask: np.roll(mask, 9, axis=1), "where the others see none", False),
    ],
)
def test_a_wrong_mask_is_named(mask, said: str, fatal: bool) -> None:
    changed = with_first(mask=mask(photographs()[0].mask))
    found = preflight(changed, seen())
    mine = [one for one in found if said in one.what]
    assert [one.where for one in mine] == ["view0.png"]
    assert mine[0].fatal == fatal


def test_a_pose_of_another_picture_is_named() -> None:
    camera = photographs()[0].camera
    tilt = np.eye(4)
    tilt[:2, :2] = [[np.cos(0.1), -np.sin(0.1)], [np.sin(0.1), np.cos(0.1)]]
    tilt[0, 3] = 0.03
    moved = with_first(camera=posed(camera, tilt @ camera.pose))
    said = words(preflight(moved, seen()))
    named = [line for line in said.split("\n") if line.endswith("others see none")]
    assert [line.split(":")[0] for line in named] == ["view0.png"]


def test_pictures_that_belong_to_no_pose_are_refused() -> None:
    random = np.random.default_rng(0)
    away = tuple(
        dataclasses.replace(one, mask=np.roll(one.mask, random.integers(-6, 7, 2), axis=(0, 1)))
        for one in photographs()
        if one.mask is not None
    )
    found = preflight(away, Region(CENTRE, 1.2 * RADIUS))
    assert found[0].fatal and found[0].where == "cameras"
    assert "poses belong to these pictures" in found[0].remedy


def test_other_axes_are_told_from_cameras_that_look_away() -> None:
    turned = tuple(
        dataclasses.replace(
            one, camera=posed(one.camera, np.diag([1.0, -1.0, -1.0, 1.0]) @ one.camera.pose)
        )
        for one in photographs()
    )
    found = preflight(turned, Region(CENTRE, 1.2 * RADIUS))
    assert found[0].fatal
    assert "camera_axes" in found[0].remedy


def test_a_camera_in_the_region_and_one_pose_twice_are_named() -> None:
    said = words(preflight(photographs(), Region(CENTRE, 0.3)))
    assert "view0.png: the camera stands inside the region" in said
    twice = (*photographs(), dataclasses.replace(photographs()[3], file="again.png"))
    said = words(preflight(twice, seen()))
    assert "again.png: the camera stands and looks as that of view3.png" in said


def test_few_photographs_of_one_side_in_another_unit_are_doubted() -> None:
    above = [one for one in photographs() if one.camera.place()[2] > CENTRE[2] + 0.05][:4]
    said = words(preflight(above, Region(CENTRE, 1.2 * RADIUS)))
    assert "there are 4 photographs" in said
    assert "no camera sees the object" in said
    far = words(preflight(photographs(), Region(CENTRE * 0 + 100.0, 50.0)))
    assert "the region's edge is 100 m" in far
