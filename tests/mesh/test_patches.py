"""Choosing boundary faces."""

import numpy as np
import pytest

from thermo.errors import InputError
from thermo.mesh import (
    box_mesh,
    cylinder_mesh,
    face_areas,
    face_centres,
    faces_in_box,
    faces_towards,
    faces_where,
)

BOX = box_mesh((1.0, 2.0, 3.0), (2, 2, 2))


def test_a_direction_takes_one_side_of_a_box():
    top = faces_towards(BOX, (0, 0, 5.0))
    assert face_areas(BOX)[top].sum() == pytest.approx(2.0)
    np.testing.assert_allclose(face_centres(BOX)[top, 2], 3.0)


def test_a_smaller_cosine_takes_more_of_a_round_side():
    rod = cylinder_mesh(0.01, 0.05, 4, 3)
    narrow, wide = (faces_towards(rod, (1, 0, 0), cosine) for cosine in (0.9, 0.5))
    assert set(narrow) < set(wide)
    assert (rod.normals[wide, 0] >= 0.5).all()


def test_box_and_predicate_agree():
    boxed = faces_in_box(BOX, (-1, -1, -1), (2, 3, 1.0))
    chosen = faces_where(BOX, lambda centres, _: centres[:, 2] <= 1.0)
    np.testing.assert_array_equal(boxed, chosen)
    assert 0 < len(boxed) < len(BOX.faces)


@pytest.mark.parametrize(
    "choose",
    [
        lambda: faces_in_box(BOX, (5, 5, 5), (6, 6, 6)),
        lambda: faces_in_box(BOX, (1, 1, 1), (0, 0, 0)),
        lambda: faces_towards(BOX, (0, 0, 0)),
        lambda: faces_towards(BOX, (1, 1, 1), 0.99),
        lambda: faces_where(BOX, lambda c, n: np.array([True])),
        lambda: faces_where(BOX, lambda c, n: c[:, 0]),
    ],
)
def test_empty_and_senseless_patches_are_refused(choose):
    with pytest.raises(InputError, match="remedy"):
        choose()
