"""What masks deny, voxel by voxel."""

from __future__ import annotations

import numpy as np
import pytest
from coloured_ball import CENTRE, RADIUS, cameras, photograph

from thermo.reconstruct import Photograph
from thermo.reconstruct._visual_hull import carve, cones_of
from thermo.reconstruct._voxels import voxels_in

PHOTOGRAPHS = [photograph(camera) for camera in cameras(10)]
GRID = voxels_in(CENTRE - 0.06, CENTRE + 0.06, 40)
AWAY = np.linalg.norm(GRID.middles() - CENTRE, axis=1)


def test_the_ball_is_denied_by_none_and_what_is_away_by_some() -> None:
    denials = carve(cones_of(PHOTOGRAPHS), GRID).denials()
    assert (denials[AWAY < RADIUS] == 0).all()
    assert (denials[AWAY > 1.6 * RADIUS] > 0).all()


def test_a_picture_that_shows_all_of_the_object_denies_what_is_out_of_it() -> None:
    first = PHOTOGRAPHS[0]
    assert first.mask is not None
    ahead = first.camera.pose[2, :3]
    place = first.camera.place()
    behind = place - 0.1 * ahead
    aside = place + 0.2 * ahead + 0.2 * first.camera.pose[0, :3]
    line = np.zeros_like(first.mask)
    line[0] = 1.0
    mask = np.maximum(first.mask, line)
    cut = Photograph(first.camera, first.colour, mask, first.file)
    for middle in (behind, aside):
        grid = voxels_in(middle - 0.01, middle + 0.01, 4)
        whole = carve(cones_of(PHOTOGRAPHS), grid)
        assert whole.denied[0].all() and (whole.denials() > 0).all()
        # What the picture's edge cuts may go on out there.
        alone = carve(cones_of([cut]), grid)
        assert not alone.denied.any()
        assert (alone.denials() == 2).all(), "nobody sees it"


def test_a_mask_that_stands_wrong_denies_the_ball_once() -> None:
    first, *rest = PHOTOGRAPHS
    assert first.mask is not None
    wrong = Photograph(first.camera, first.colour, np.roll(first.mask, 14, axis=1), first.file)
    carving = carve(cones_of([wrong, *rest]), GRID)
    inner = AWAY < 0.15 * RADIUS
    assert carving.denied[0, inner].all() and not carving.denied[1:, inner].any()


def test_photographs_without_a_mask_or_an_object_have_no_cone() -> None:
    first, second, third, *_ = PHOTOGRAPHS
    assert third.mask is not None
    without = Photograph(first.camera, first.colour, None, first.file)
    empty = Photograph(second.camera, second.colour, 0 * third.mask, second.file)
    assert [one.number for one in cones_of([without, empty, third])] == [2]


@pytest.mark.parametrize("longest", [1, 7])
def test_voxels_fill_their_box(longest: int) -> None:
    low, high = np.array([0.0, 1.0, -1.0]), np.array([0.7, 1.2, -0.65])
    grid = voxels_in(low, high, longest)
    assert max(grid.cells) == longest
    reach = low + grid.edge * np.array(grid.cells)
    assert (reach >= high - 1e-12).all() and (reach < high + grid.edge).all()
    assert grid.middles().min(axis=0) == pytest.approx(low + 0.5 * grid.edge)
    assert len(grid.middles()) == np.prod(grid.cells)
