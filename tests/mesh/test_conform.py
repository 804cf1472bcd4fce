"""Meshes that hold what their surface holds."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.mesh import (
    Surface,
    ball_mesh,
    box_mesh,
    cell_quality,
    cell_volumes,
    cylinder_mesh,
    mesh_from_cells,
)
from thermo.mesh._conform import conformed
from thermo.mesh._gate import LEAST_QUALITY


def moved(mesh, surface):
    """The mesh conformed to a surface."""
    return mesh_from_cells(conformed(mesh, surface), mesh.cells)


def surface_of(shape):
    return Surface(np.asarray(shape.vertices, float), np.asarray(shape.faces, np.int64))


@settings(max_examples=10, deadline=None)
@given(st.floats(0.005, 0.5), st.integers(2, 4), st.tuples(*[st.floats(0.4, 2.0)] * 3))
def test_ellipsoids_hold_their_volume(radius, level, axes):
    ball = ball_mesh(radius, level)
    mesh = mesh_from_cells(ball.nodes * axes, ball.cells)
    fine = trimesh.creation.icosphere(subdivisions=5, radius=radius)
    surface = surface_of(fine.apply_transform(np.diag([*axes, 1.0])))
    before, after = (one.volume() / surface.volume() - 1 for one in (mesh, moved(mesh, surface)))
    assert before < -0.005 and abs(after) < 0.1 * abs(before)
    inside = np.setdiff1d(np.arange(len(mesh.nodes)), mesh.surface_nodes)
    np.testing.assert_array_equal(conformed(mesh, surface)[inside], mesh.nodes[inside])


def test_the_error_of_a_ball_falls_with_the_fourth_power_of_its_faces():
    surface = surface_of(trimesh.creation.icosphere(subdivisions=7, radius=0.025))
    before, after = [], []
    for level in (2, 4):
        mesh = ball_mesh(0.025, level)
        for found, one in ((before, mesh), (after, moved(mesh, surface))):
            found.append(abs(one.volume() / surface.volume() - 1))
    # What faces with corners on the ball lack goes with their square.
    power = 2 * np.log(after[0] / after[1]) / np.log(before[0] / before[1])
    assert power == pytest.approx(4, abs=0.3)


def test_ends_of_a_rod_stay_flat_and_its_side_moves_outward():
    mesh = cylinder_mesh(0.01, 0.04, 3, 6)
    surface = surface_of(trimesh.creation.cylinder(0.01, 0.04, sections=400))
    ends = np.ptp(mesh.nodes[:, 2])
    surface = Surface(surface.vertices + [0, 0, mesh.nodes[:, 2].mean()], surface.triangles)
    after = moved(mesh, surface)
    before = mesh.volume() / surface.volume() - 1
    assert before < -0.02 and abs(after.volume() / surface.volume() - 1) < 0.1 * abs(before)
    flat = np.isclose(np.abs(mesh.nodes[:, 2] - mesh.nodes[:, 2].mean()), ends / 2)
    np.testing.assert_allclose(after.nodes[flat, 2], mesh.nodes[flat, 2], atol=1e-6)


@pytest.mark.parametrize("short", [0.0, 1e-3])
def test_a_box_keeps_its_sides_and_gets_its_corners_back(short):
    mesh = box_mesh((0.04, 0.02, 0.01), (4, 3, 2))
    box = surface_of(trimesh.creation.box((0.04, 0.02, 0.01)))
    centre = mesh.nodes.mean(axis=0)
    surface = Surface(box.vertices + centre, box.triangles)
    inner = mesh_from_cells(centre + (1 - short) * (mesh.nodes - centre), mesh.cells)
    after = moved(inner, surface)
    on = np.isclose(np.abs(mesh.nodes - centre), [0.02, 0.01, 0.005])
    np.testing.assert_allclose(after.nodes[on], mesh.nodes[on], atol=1e-12)


@pytest.mark.parametrize("height", [0.04, 1e-3])
def test_no_cell_is_turned_over_or_made_flat_by_a_surface_that_is_another(height):
    half = height / 2
    mesh = box_mesh((0.04, 0.04, height), (4, 4, 4), origin=(-0.02, -0.02, -half))
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.024)
    surface = surface_of(ball.apply_transform(np.diag([1.0, 1.0, half / 0.02, 1.0])))
    nodes = conformed(mesh, surface)
    assert np.any(nodes != mesh.nodes)
    after = mesh_from_cells(nodes, mesh.cells)
    np.testing.assert_array_equal(after.cells, mesh.cells)
    assert cell_volumes(after).min() > 0
    assert cell_quality(after).min() >= min(LEAST_QUALITY, cell_quality(mesh).min())


@pytest.mark.parametrize("cut", [0.0, 1e-4])
def test_faces_of_a_box_stay_in_its_planes_where_an_edge_is_cut_off(cut):
    mesh = box_mesh((0.04, 0.02, 0.01), (4, 3, 2))
    box = trimesh.creation.box(bounds=[[0.0] * 3, [0.04, 0.02, 0.01]])
    nodes = mesh.nodes.copy()
    # A corner is drawn back within the plane z = 0.
    corner = int(np.argmin(np.linalg.norm(nodes, axis=1)))
    nodes[corner] += [cut, cut, 0.0]
    after = moved(mesh_from_cells(nodes, mesh.cells), surface_of(box)).nodes
    for plane in (0.0, 0.01):
        np.testing.assert_array_equal(after[mesh.nodes[:, 2] == plane, 2], plane)
    far = np.linalg.norm(mesh.nodes - mesh.nodes[corner], axis=1) > 0.02
    np.testing.assert_allclose(after[far], mesh.nodes[far], atol=1e-15)
