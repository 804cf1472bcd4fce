"""Boxes, cylinders and balls."""

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.mesh import ball_mesh, box_mesh, cell_quality, cylinder_mesh


def test_box_fills_its_sides_exactly():
    mesh = box_mesh((1.0, 2.0, 3.0), (2, 3, 4), origin=(-1.0, 0.0, 5.0))
    assert mesh.volume() == pytest.approx(6.0) and mesh.area() == pytest.approx(22.0)
    assert len(mesh.nodes) == 3 * 4 * 5 and len(mesh.cells) == 6 * 2 * 3 * 4
    np.testing.assert_allclose(mesh.nodes.min(axis=0), [-1, 0, 5])
    np.testing.assert_allclose(mesh.nodes.max(axis=0), [0, 2, 8])


@pytest.mark.parametrize("rings", [1, 2, 5])
def test_cylinder_is_the_inscribed_prism(rings):
    mesh = cylinder_mesh(0.02, 0.06, rings, 3)
    sides = 6 * rings
    section = 0.5 * sides * 0.02**2 * np.sin(2 * np.pi / sides)
    assert mesh.volume() == pytest.approx(section * 0.06)
    assert mesh.area() == pytest.approx(2 * section + sides * 0.06 * 0.04 * np.sin(np.pi / sides))
    assert cell_quality(mesh).min() > 0.1


def test_ball_converges_to_the_sphere_at_second_order():
    exact = 4 / 3 * np.pi * 0.025**3
    errors = [1 - ball_mesh(0.025, shells).volume() / exact for shells in (3, 6, 12)]
    assert errors[0] > errors[1] > errors[2] > 0
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.15)
    mesh = ball_mesh(0.025, 4)
    radii = np.linalg.norm(mesh.nodes, axis=1)
    np.testing.assert_allclose(radii[mesh.surface_nodes], 0.025)
    np.testing.assert_allclose(np.unique(radii.round(9)), 0.025 * np.arange(5) / 4, atol=1e-9)
    assert cell_quality(mesh).min() > 0.5


@pytest.mark.parametrize(
    "make",
    [
        lambda: box_mesh((1, 0, 1), (1, 1, 1)),
        lambda: box_mesh((1, 1, np.inf), (1, 1, 1)),
        lambda: box_mesh((1, 1, 1), (1, 1, 0)),
        lambda: cylinder_mesh(-1.0, 1.0, 1, 1),
        lambda: cylinder_mesh(1.0, 1.0, 0, 1),
        lambda: ball_mesh(1.0, 0),
        lambda: ball_mesh(np.nan, 2),
    ],
)
def test_impossible_bodies_are_refused(make):
    with pytest.raises(InputError, match="remedy"):
        make()
