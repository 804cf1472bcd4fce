"""Binding points to the boundary."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.mesh import ball_mesh, box_mesh, cylinder_mesh, locate, promote

BALL = ball_mesh(0.025, 3)
MESHES = {
    (shape, order): mesh if order == 1 else promote(mesh)
    for shape, mesh in (("ball", BALL), ("rod", cylinder_mesh(0.005, 0.2, 2, 40)))
    for order in (1, 2)
}


def sample(mesh, rng, count):
    """Random points on the boundary and the faces they lie on."""
    face = rng.integers(len(mesh.faces), size=count)
    weights = rng.dirichlet([1.0, 1.0, 1.0], size=count)
    return np.einsum("sk,ski->si", weights, mesh.nodes[mesh.faces[face, :3]])


@settings(max_examples=25, deadline=None)
@given(st.sampled_from(sorted(MESHES)), st.integers(0, 2**32 - 1))
def test_weights_reproduce_positions_and_polynomials(key, seed):
    mesh, rng = MESHES[key], np.random.default_rng(seed)
    points = sample(mesh, rng, 30)
    bound = locate(mesh, points)
    np.testing.assert_allclose(bound.weights.sum(axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(bound.distance, 0.0, atol=1e-12)
    got = np.einsum("sq,sqi->si", bound.weights, mesh.nodes[bound.nodes])
    np.testing.assert_allclose(got, points, atol=1e-12)
    slope, curve = rng.normal(size=3), rng.normal(size=(3, 3))

    def field(x):
        square = np.einsum("...i,ij,...j->...", x, curve, x)
        return 1.0 + x @ slope + (square if mesh.order == 2 else 0.0)

    read = (bound.weights * field(mesh.nodes[bound.nodes])).sum(axis=1)
    np.testing.assert_allclose(read, field(points), atol=1e-12)
    np.testing.assert_array_equal(bound.nodes, mesh.faces[bound.face])


def test_distance_off_a_flat_side_and_off_a_corner():
    mesh = box_mesh((1.0, 1.0, 1.0), (3, 3, 3))
    bound = locate(mesh, np.array([[0.4, 0.3, 1.2], [1.3, 1.4, 1.0], [0.45, 0.5, 0.1]]))
    np.testing.assert_allclose(bound.distance, [0.2, 0.5, 0.1], atol=1e-12)
    np.testing.assert_allclose(mesh.normals[bound.face[0]], [0, 0, 1])


@pytest.mark.parametrize("points", [np.zeros(3), np.zeros((2, 2)), np.full((1, 3), np.nan)])
def test_bad_points_are_refused(points):
    with pytest.raises(InputError, match="points"):
        locate(BALL, points)
