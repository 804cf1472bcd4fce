"""Validation of nodes and cells, and the boundary."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.mesh import (
    box_mesh,
    cell_quality,
    cell_volumes,
    face_areas,
    face_centres,
    mesh_from_cells,
    promote,
)

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
ONE = np.array([[0, 1, 2, 3]])


def test_one_cell_has_four_outward_faces():
    mesh = mesh_from_cells(CORNERS, ONE)
    assert mesh.order == 1 and len(mesh.faces) == 4
    assert mesh.volume() == pytest.approx(1 / 6)
    away = face_centres(mesh) - CORNERS.mean(axis=0)
    assert (np.einsum("ij,ij->i", away, mesh.normals) > 0).all()
    assert face_areas(mesh).sum() == pytest.approx(1.5 + np.sqrt(3) / 2)
    assert mesh.area() == pytest.approx(face_areas(mesh).sum())
    for leaf in (mesh.cells, mesh.faces, mesh.owners, mesh.regions):
        assert leaf.dtype == np.int32


@pytest.mark.parametrize("quadratic", [False, True])
def test_inside_out_cells_are_turned(quadratic):
    base = box_mesh((1, 1, 1), (2, 2, 2))
    base = promote(base) if quadratic else base
    flip = [0, 2, 1, 3, 6, 5, 4, 7, 9, 8][: base.cells.shape[1]]
    mixed = base.cells.copy()
    mixed[::2] = mixed[::2][:, flip]
    mesh = mesh_from_cells(base.nodes, mixed)
    np.testing.assert_array_equal(mesh.cells, base.cells)
    assert (cell_volumes(mesh) > 0).all()


def test_unused_nodes_are_dropped_and_the_rest_renumbered():
    nodes = np.concatenate([[[9.0, 9, 9]], CORNERS, [[8.0, 8, 8]]])
    mesh = mesh_from_cells(nodes, ONE + 1)
    np.testing.assert_array_equal(mesh.nodes, CORNERS)
    assert set(mesh.cells.ravel()) == {0, 1, 2, 3}


def test_middle_nodes_of_faces_lie_between_their_corners():
    mesh = mesh_from_cells(*_arrays(promote(box_mesh((1, 2, 3), (2, 1, 1)))))
    points = mesh.nodes[mesh.faces]
    for middle, (a, b) in zip((3, 4, 5), ((0, 1), (1, 2), (2, 0)), strict=True):
        np.testing.assert_allclose(points[:, middle], 0.5 * (points[:, a] + points[:, b]))


def _arrays(mesh):
    return mesh.nodes, mesh.cells


def test_regions_follow_the_cells():
    mesh = mesh_from_cells(CORNERS, ONE, regions=np.array([3]))
    assert mesh.regions.tolist() == [3]


def test_quality_is_one_for_a_regular_cell_and_small_for_a_flat_one():
    regular = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    assert cell_quality(mesh_from_cells(regular, ONE))[0] == pytest.approx(1.0)
    flat = CORNERS * [1, 1, 1e-3]
    assert cell_quality(mesh_from_cells(flat, ONE))[0] < 0.05


BAD = {
    "no cells": (CORNERS, np.zeros((0, 4), int), {}),
    "hexahedra": (CORNERS, np.zeros((1, 8), int), {}),
    "fractions": (CORNERS, ONE + 0.5, {}),
    "flat nodes": (CORNERS[:, :2], ONE, {}),
    "nan": (np.where(CORNERS == 1, np.nan, CORNERS), ONE, {}),
    "out of range": (CORNERS, ONE + 1, {}),
    "negative": (CORNERS, ONE - 1, {}),
    "degenerate": (CORNERS * [1, 1, 0], ONE, {}),
    "doubled": (CORNERS, np.repeat(ONE, 2, axis=0), {}),
    "tripled": (CORNERS, np.repeat(ONE, 3, axis=0), {}),
    "overlapping": (
        np.concatenate([CORNERS, [[0.2, 0.2, 2.0]]]),
        np.array([[0, 1, 2, 3], [0, 1, 2, 4]]),
        {},
    ),
    "regions": (CORNERS, ONE, {"regions": np.array([0, 1])}),
    "negative region": (CORNERS, ONE, {"regions": np.array([-1])}),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_cells_are_refused_by_name(name):
    nodes, cells, more = BAD[name]
    with pytest.raises(InputError, match="my mesh"):
        mesh_from_cells(nodes, cells, where="my mesh", **more)


def test_curved_edges_are_refused():
    mesh = promote(mesh_from_cells(CORNERS, ONE))
    nodes = mesh.nodes.copy()
    nodes[-1] += 0.05
    with pytest.raises(InputError, match="promote"):
        mesh_from_cells(nodes, mesh.cells)


@settings(max_examples=20, deadline=None)
@given(
    st.tuples(*[st.integers(1, 3)] * 3),
    st.tuples(*[st.floats(0.1, 5.0)] * 3),
    st.integers(0, 2**32 - 1),
)
def test_boundary_is_closed_and_volume_kept_under_moves(divisions, lengths, seed):
    rng = np.random.default_rng(seed)
    box = box_mesh(lengths, divisions)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    mesh = mesh_from_cells(box.nodes @ turn.T + rng.normal(size=3), box.cells)
    assert mesh.volume() == pytest.approx(np.prod(lengths), rel=1e-9)
    vectors = mesh.normals * face_areas(mesh)[:, None]
    np.testing.assert_allclose(vectors.sum(axis=0), 0.0, atol=1e-9 * mesh.area())
    flux = np.einsum("ij,ij->", face_centres(mesh), vectors) / 3
    assert flux == pytest.approx(np.prod(lengths), rel=1e-9)
    owned = mesh.cells[mesh.owners]
    assert (mesh.faces[:, :, None] == owned[:, None, :]).any(axis=2).all()
