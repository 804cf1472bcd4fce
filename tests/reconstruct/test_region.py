"""The cube that holds the object, stated or found."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from coloured_ball import CENTRE, RADIUS, cameras, photograph

from thermo.errors import InputError
from thermo.imaging import Camera
from thermo.reconstruct import Photograph, Region, region_of
from thermo.reconstruct._region import MARGIN, from_unit, to_unit


@cache
def photographs(turn: float = 0.0) -> tuple[Photograph, ...]:
    return tuple(photograph(camera) for camera in cameras(10, turn))


def bare(given: tuple[Photograph, ...]) -> tuple[Photograph, ...]:
    return tuple(Photograph(one.camera, one.colour, None, one.file) for one in given)


def test_a_stated_box_decides_and_gets_its_margin() -> None:
    region = region_of(photographs(), [[0.0, -1.0, 2.0], [1.0, 1.0, 3.0]])
    assert region.centre == pytest.approx([0.5, 0.0, 2.5])
    assert region.half == pytest.approx(1.0 + MARGIN)
    assert region.room == pytest.approx(np.array([[0.0, -1.0, 2.0], [1.0, 1.0, 3.0]]))


def test_masks_leave_a_cube_that_holds_the_ball_and_little_more() -> None:
    region = region_of(photographs())
    assert (np.abs(CENTRE - region.centre) + RADIUS < region.half).all()
    # Masks of 19 pixels across, with one of slack, and half a voxel.
    assert region.half < 1.35 * RADIUS
    assert region.room is not None
    assert (region.room[0] < CENTRE - RADIUS).all() and (region.room[1] > CENTRE + RADIUS).all()


def test_without_masks_the_cameras_say_where_to_look() -> None:
    region = region_of(bare(photographs()))
    # They all look at the ball's middle, 0.2 m away, with half a picture of 1 / 4.4.
    assert region.centre == pytest.approx(CENTRE, abs=1e-6)
    assert region.half == pytest.approx((1.0 + MARGIN) * 0.2 / 4.4, rel=1e-6)
    assert region.room is None, "a guess cuts nothing off"


def test_one_camera_that_stands_wrong_does_not_move_the_place() -> None:
    first, *rest = bare(photographs())
    pose = first.camera.pose.copy()
    pose[0, 3] += 0.1
    camera = first.camera
    moved = Camera(camera.width, camera.height, camera.focal, camera.centre, pose)
    astray = Photograph(moved, first.colour, None, first.file)
    region = region_of((astray, *rest))
    assert region.centre == pytest.approx(CENTRE, abs=1e-3)


def test_the_unit_of_a_region_goes_there_and_back() -> None:
    region = Region(np.array([1.0, 2.0, 3.0]), 0.5)
    points = np.array([[1.5, 2.0, 3.0], [1.0, 1.5, 3.25]])
    assert to_unit(region, points) == pytest.approx(np.array([[1.0, 0, 0], [0, -1.0, 0.5]]))
    assert from_unit(region, to_unit(region, points)) == pytest.approx(points)


@pytest.mark.parametrize(
    "box", [[[0, 0, 0], [1, 0, 1]], [[0, 0], [1, 1]], [[0, 0, 0], [1, 1, float("inf")]], "box"]
)
def test_what_is_no_box_is_refused(box: object) -> None:
    with pytest.raises(InputError) as caught:
        region_of(photographs(), box)
    assert caught.value.where == "box"


@pytest.mark.parametrize("count", [0, 1])
def test_too_few_cameras_say_nothing_of_the_place(count: int) -> None:
    with pytest.raises(InputError, match="where the object is"):
        region_of(photographs()[:count])
    with pytest.raises(InputError, match="where the object is"):
        region_of(bare(photographs()[:1]) * 2)
