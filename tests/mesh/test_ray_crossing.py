from __future__ import annotations

import numpy as np
import pytest
import trimesh

from thermo.mesh._ray_crossing import crossings, neighbours_across

CORNERS = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1.0, 0, 0], [1, 1, 0], [0, 1, 0]]])
ACROSS = np.array([[1, -1, -1], [-1, 0, -1]])
DOWN = np.array([[0.0, 0.0, -1.0]])


def test_neighbours_share_the_edge_opposite_of_the_corner() -> None:
    faces = np.asarray(trimesh.creation.icosphere(subdivisions=1).faces)
    across = neighbours_across(faces)
    for triangle in range(len(faces)):
        for corner in range(3):
            other = faces[across[triangle, corner]]
            shared = set(faces[triangle]) & set(other)
            assert shared == set(faces[triangle]) - {faces[triangle, corner]}
    np.testing.assert_array_equal(neighbours_across(np.array([[0, 1, 2], [1, 3, 2]])), ACROSS)


def test_a_line_is_followed_to_the_triangle_that_it_crosses() -> None:
    start = np.array([[0.75, 0.75, 2.0]])
    found = crossings(CORNERS, ACROSS, np.array([0]), start, DOWN)
    assert found.crossed[0] and found.triangle[0] == 1
    np.testing.assert_allclose(found.weights[0] @ CORNERS[1], [0.75, 0.75, 0.0])
    assert found.along[0] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("start", "proposed"), [([1.5, 0.75, 2.0], 0), ([0.2, 0.2, -1.0], 0), ([0.2, 0.2, 1.0], -1)]
)
def test_lines_that_cross_nothing(start: list[float], proposed: int) -> None:
    found = crossings(CORNERS, ACROSS, np.array([proposed]), np.array([start]), DOWN)
    assert not found.crossed[0]


@pytest.mark.parametrize("second", [[0.0, 0, 1], [0.0, 1, 0.5]])
def test_a_triangle_seen_edge_on_is_passed(second: list[float]) -> None:
    edge_on = np.array([[0.0, 0, 0], second, [0, 1, 0]])
    corners = np.stack([edge_on, CORNERS[0]])
    found = crossings(
        corners,
        np.array([[1, 1, 1], [0, -1, -1]]),
        np.array([0]),
        np.array([[0.1, 0.1, 3.0]]),
        DOWN,
    )
    assert found.crossed[0] and found.triangle[0] == 1
