"""TET4 to TET10 and back."""

import numpy as np
import pytest

from thermo.mesh import ball_mesh, box_mesh, linear, mesh_from_cells, promote

EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]


@pytest.mark.parametrize("mesh", [box_mesh((1, 2, 3), (2, 2, 1)), ball_mesh(0.02, 3)])
def test_promotion_puts_nodes_in_the_middle_and_can_be_undone(mesh):
    quadratic = promote(mesh)
    assert quadratic.order == 2 and quadratic.faces.shape == (len(mesh.faces), 6)
    for place, (a, b) in enumerate(EDGES):
        middle = 0.5 * (mesh.nodes[mesh.cells[:, a]] + mesh.nodes[mesh.cells[:, b]])
        np.testing.assert_allclose(quadratic.nodes[quadratic.cells[:, 4 + place]], middle)
    assert len(np.unique(quadratic.nodes.round(9), axis=0)) == len(quadratic.nodes)
    assert quadratic.volume() == pytest.approx(mesh.volume())
    back = linear(quadratic)
    for name in ("nodes", "cells", "faces", "owners", "normals", "regions"):
        np.testing.assert_array_equal(getattr(back, name), getattr(mesh, name))


def test_promoted_faces_equal_those_found_from_the_cells():
    quadratic = promote(box_mesh((1, 1, 1), (2, 1, 2)))
    found = mesh_from_cells(quadratic.nodes, quadratic.cells)
    np.testing.assert_array_equal(quadratic.faces, found.faces)
    np.testing.assert_array_equal(quadratic.owners, found.owners)


def test_both_leave_their_own_order_alone():
    mesh = box_mesh((1, 1, 1), (1, 1, 1))
    quadratic = promote(mesh)
    assert linear(mesh) is mesh and promote(quadratic) is quadratic
