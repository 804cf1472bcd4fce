"""Where a surface turns inward."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from angled import angled

from thermo.mesh import Surface, inner_edges

from .conftest import as_surface


@pytest.mark.parametrize("spacing", [0.0015, 0.02, 1.0])
def test_points_lie_along_the_inner_edge_and_no_other(spacing: float) -> None:
    found = inner_edges(angled(), spacing)
    np.testing.assert_allclose(found[:, [0, 2]], 0.01, atol=1e-15)
    along = np.sort(found[:, 1])
    gaps = np.diff(np.concatenate([[-along[0]], along, [0.04 - along[-1]]]))
    np.testing.assert_allclose(gaps, 0.02 / len(found))
    assert len(found) == np.ceil(0.02 / spacing)


def test_bodies_without_one_have_none(cube: Surface, ball: Surface) -> None:
    assert inner_edges(cube, 1e-3).shape == inner_edges(ball, 1e-3).shape == (0, 3)


def test_a_bore_has_none_but_where_it_ends() -> None:
    # The side of a round hole turns inward by little from facet to facet.
    cup = trimesh.creation.revolve(
        np.array([[0, 0], [20, 0], [20, 36], [14, 36], [14, 6], [0, 6]]) * 1e-3, sections=64
    )
    cup.fix_normals()
    found = inner_edges(as_surface(cup), 5e-4)
    np.testing.assert_allclose(found[:, 2], 0.006)
    around = np.linalg.norm(found[:, :2], axis=1)
    assert len(found) == 64 * 3 and np.all((around > 0.01398) & (around <= 0.014 + 1e-9))
