"""Shares of cut simplices: against sampling, the other side's, and a box that a plane cuts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.fields._cut_simplex import share_above
from thermo.mesh import box_mesh, cell_volumes, face_areas

HEIGHTS = st.lists(st.integers(-6, 6).map(float), min_size=4, max_size=4)


@given(heights=HEIGHTS, corners=st.sampled_from([3, 4]), unit=st.sampled_from([1e-9, 1.0, 1e6]))
def test_it_is_the_share_of_points_drawn_and_of_no_other_side(
    heights: list[float], corners: int, unit: float
) -> None:
    here = unit * np.array([heights[:corners]])
    weights = np.random.default_rng(0).dirichlet(np.ones(corners), 4000)
    drawn = np.mean(weights @ here[0] > 0) + 0.5 * np.mean(weights @ here[0] == 0)
    (share,) = share_above(here)
    if np.any(here):
        assert share == pytest.approx(drawn, abs=0.03)
        assert share_above(-here)[0] == pytest.approx(1 - share, abs=1e-4)
    assert share_above(here[:, ::-1])[0] == pytest.approx(share, abs=1e-4)


def test_one_that_is_not_cut_is_whole_or_nothing() -> None:
    heights = np.array([[1.0, 2.0, 3.0, 1e-9], [-1.0, -2.0, -2.0, -2.0], [0.0, 0.0, 0.0, 1.0]])
    assert share_above(heights) == pytest.approx([1.0, 0.0, 1.0], abs=1e-12)


@given(axis=st.integers(0, 2), place=st.floats(0.01, 0.99))
def test_a_plane_across_a_box_leaves_what_lies_above_it(axis: int, place: float) -> None:
    size = (1.0, 2.0, 3.0)
    mesh = box_mesh(size, (3, 3, 3))
    height = mesh.nodes[:, axis] - mesh.nodes[:, axis].min() - place * size[axis]
    share = cell_volumes(mesh) @ share_above(height[mesh.cells]) / np.prod(size)
    assert share == pytest.approx(1 - place, abs=1e-4)


@given(
    way=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda way: np.linalg.norm(way) > 0.1),
)
def test_a_plane_through_the_middle_of_a_box_halves_its_volume_and_its_skin(
    way: tuple[float, float, float],
) -> None:
    mesh = box_mesh((1.0, 2.0, 3.0), (3, 3, 3))
    height = (mesh.nodes - mesh.nodes.mean(0)) @ np.array(way)
    for parts, sizes in ((mesh.cells, cell_volumes(mesh)), (mesh.faces, face_areas(mesh))):
        assert sizes @ share_above(height[parts]) == pytest.approx(0.5 * sizes.sum(), rel=1e-4)
