"""Where an effect is told to be, whose shape has its middle in the body or beside it."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from thermo.discover._within_body import within_body
from thermo.mesh import box_mesh

SIZE = np.array([0.04, 0.02, 0.01])
BOX = box_mesh(tuple(SIZE), (4, 3, 2))
LOW, HIGH = BOX.nodes.min(0), BOX.nodes.max(0)


@given(st.tuples(*[st.floats(-2.0, 3.0)] * 3))
def test_of_a_box_it_is_the_point_of_the_box_that_is_nearest(share: tuple[float, ...]) -> None:
    point = LOW + np.array(share) * SIZE
    found = within_body(point, BOX)
    np.testing.assert_allclose(found, np.clip(point, LOW, HIGH), rtol=0, atol=1e-9)


@pytest.mark.parametrize("share", [(0.5, 0.5, 1.0), (0.0, 0.0, 0.0), (0.25, 1 / 3, 0.5)])
def test_on_the_skin_and_between_cells_a_point_stays(share: tuple[float, ...]) -> None:
    point = LOW + np.array(share) * SIZE
    assert within_body(point, BOX) == pytest.approx(point, abs=1e-12)
