"""Control points on the surface and the graph of their neighbours."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from thermo.errors import InputError
from thermo.fields import place_control_points, surface_vertices
from thermo.mesh import Mesh, ball_mesh, box_mesh, promote


def links(mesh: Mesh, count: int):
    points = place_control_points(mesh, count)
    number = len(points.vertex)
    pairs = points.pairs
    graph = csr_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(number, number))
    return points, graph


def test_surface_vertices_are_corners_only() -> None:
    mesh = promote(ball_mesh(0.05, 2))
    nodes, faces = surface_vertices(mesh)
    np.testing.assert_allclose(np.linalg.norm(mesh.nodes[nodes], axis=1), 0.05)
    np.testing.assert_array_equal(nodes[faces], mesh.faces[:, :3])
    assert len(nodes) - len(faces) * 3 // 2 + len(faces) == 2  # Euler


@pytest.mark.parametrize("count", [0, -3])
def test_no_control_points_are_refused(count: int) -> None:
    with pytest.raises(InputError, match="needs control points"):
        place_control_points(ball_mesh(0.05, 2), count)


def test_control_points_are_spread_and_connected() -> None:
    points, graph = links(ball_mesh(0.05, 4), 20)
    nodes, _ = surface_vertices(ball_mesh(0.05, 4))
    assert len(set(points.vertex.tolist())) == 20
    np.testing.assert_array_equal(points.points, ball_mesh(0.05, 4).nodes[nodes[points.vertex]])
    assert connected_components(graph, directed=False)[0] == 1
    assert (points.pairs[:, 0] < points.pairs[:, 1]).all()
    assert len(np.unique(points.pairs, axis=0)) == len(points.pairs)
    # Farthest-point sampling: no two closer than half of the widest gap that is left.
    between = points.distance[:, points.vertex] + np.eye(20)
    assert between.min() > 0.5 * points.distance.min(0).max()
    np.testing.assert_array_equal(np.diag(points.distance[:, points.vertex]), 0.0)


def test_distances_run_along_the_surface() -> None:
    points = place_control_points(ball_mesh(0.05, 6), 6)
    straight = np.linalg.norm(points.points[:, None] - points.points[None], axis=2)
    arc = 2 * 0.05 * np.arcsin(np.clip(straight / 0.1, 0, 1))
    along = points.distance[:, points.vertex]
    assert (along >= straight - 1e-12).all()
    far = ~np.eye(6, dtype=bool)
    assert (np.abs(along / np.where(far, arc, 1) - 1)[far] < 0.2).all()


def test_no_pair_reaches_through_a_thin_wall() -> None:
    mesh = box_mesh((0.2, 0.2, 0.004), (12, 12, 1))
    points, graph = links(mesh, 60)
    assert connected_components(graph, directed=False)[0] == 1
    height, place = points.points[:, 2], points.points[:, :2]
    rim = np.minimum(place, 0.2 - place).min(1)
    first, second = points.pairs.T
    across = np.abs(height[first] - height[second]) > 1e-9
    deep = np.minimum(rim[first], rim[second]) > 0.05
    assert deep.any()
    assert not (across & deep).any()
    # In a straight line there would be such pairs: the two sides are 4 mm apart.
    inner = np.flatnonzero(rim > 0.05)
    gap = np.linalg.norm(points.points[inner][:, None] - points.points[inner], axis=2)
    opposite = np.abs(height[inner][:, None] - height[inner]) > 1e-9
    assert gap[opposite].min() < 0.03
    assert points.distance[inner][:, points.vertex[inner]][opposite].min() > 0.1


def test_the_active_part_holds_more_points() -> None:
    mesh = box_mesh((0.2, 0.1, 0.02), (20, 10, 2))
    nodes, _ = surface_vertices(mesh)
    active = mesh.nodes[nodes, 0] < 0.1 + 1e-9
    plain = place_control_points(mesh, 50)
    biased = place_control_points(mesh, 50, active=active)
    assert 0.4 < active[plain.vertex].mean() < 0.65
    # Nine times as dense: about 0.9 of the points on half of the area.
    assert 0.8 < active[biased.vertex].mean() < 0.98


def test_points_repeat_with_their_seed_and_stop_at_every_vertex() -> None:
    mesh = box_mesh((0.1, 0.1, 0.1), (2, 2, 2))
    one, same, other = (place_control_points(mesh, 8, seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.vertex, same.vertex)
    assert not np.array_equal(one.vertex, other.vertex)
    assert len(place_control_points(mesh, 1000).vertex) == 26


def test_separate_bodies_are_far_apart_yet_finite() -> None:
    left = box_mesh((0.1, 0.1, 0.1), (1, 1, 1))
    right = box_mesh((0.1, 0.1, 0.1), (1, 1, 1), origin=(0.2, 0, 0))
    shift = len(left.nodes)
    both = Mesh(
        nodes=np.concatenate([left.nodes, right.nodes]),
        cells=np.concatenate([left.cells, right.cells + shift]),
        faces=np.concatenate([left.faces, right.faces + shift]),
        owners=np.concatenate([left.owners, right.owners + len(left.cells)]),
        normals=np.concatenate([left.normals, right.normals]),
        regions=np.concatenate([left.regions, right.regions]),
    )
    points = place_control_points(both, 6)
    assert np.isfinite(points.distance).all()
    side = points.points[:, 0] > 0.15
    assert side.any() and not side.all()
    across = side[points.pairs[:, 0]] != side[points.pairs[:, 1]]
    assert not across.any()
