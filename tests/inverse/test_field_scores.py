"""Scores of a field: by hand on two faces' worth of area, and by area or not."""

from __future__ import annotations

import numpy as np
import pytest

from thermo.inverse import RecoveredField, field_scores
from thermo.mesh import box_mesh, face_areas, face_centres

MESH = box_mesh((0.02, 0.02, 0.002), (2, 2, 6))


def recovered(faces: np.ndarray) -> RecoveredField:
    return RecoveredField("conductivity", "W/m/K", np.ones(len(MESH.cells)), faces)


def test_a_true_field_has_no_error_and_no_width() -> None:
    truth = 1.0 + face_centres(MESH)[:, 0]
    scores = field_scores(MESH, recovered(truth), truth)
    assert scores.error == scores.plain_error == scores.width == 0.0 and scores.ratio == 1.0
    assert scores.width_by_median > 0


def test_large_faces_count_more() -> None:
    areas = face_areas(MESH)
    wide = areas > np.median(areas)
    scores = field_scores(MESH, recovered(np.where(wide, 2.2, 1.6)), 2.0)
    share = areas[wide].sum() / areas.sum()
    assert scores.error == pytest.approx(share * 0.1 + (1 - share) * 0.2)
    assert scores.plain_error == pytest.approx(wide.mean() * 0.1 + (~wide).mean() * 0.2)
    assert scores.ratio == pytest.approx(1.1)
    assert scores.width == pytest.approx(0.3, rel=0.2)
    assert scores.width_by_median == pytest.approx(scores.width / 1.1)
