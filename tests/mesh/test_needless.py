"""Vertices that a surface would be the same without."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from thermo.mesh import Surface
from thermo.mesh._needless import needless_share


def cut_box(times: int) -> trimesh.Trimesh:
    body = trimesh.creation.box((0.06, 0.04, 0.02))
    for _ in range(times):
        body = body.subdivide()
    return body


def read(body: trimesh.Trimesh) -> Surface:
    return Surface(np.array(body.vertices, float), np.array(body.faces, np.int64))


@given(times=st.integers(0, 3), size=st.floats(1e-3, 10.0), seed=st.integers(0, 1000))
def test_of_a_box_the_corners_alone_are_needed(times: int, size: float, seed: int) -> None:
    body = cut_box(times)
    body.apply_transform(trimesh.transformations.random_rotation_matrix(
        np.random.default_rng(seed).random(3)
    ))  # fmt: skip
    body.apply_scale(size)
    count = len(body.vertices)
    assert needless_share(read(body)) == pytest.approx((count - 8) / count)


def test_of_a_ball_all_are_needed() -> None:
    assert needless_share(read(trimesh.creation.icosphere(3, 0.02))) == 0.0


def test_of_a_prism_those_on_its_edges_and_faces_are_not() -> None:
    prism = trimesh.creation.cylinder(0.02, 0.03, sections=12)
    # Its corners are needed, the middle of its lids are not, nor is any that a cut adds.
    finer = prism.subdivide()
    assert needless_share(read(prism)) == pytest.approx(2 / 26)
    assert needless_share(read(finer)) == pytest.approx(1 - 24 / len(finer.vertices))


@pytest.mark.parametrize(("height", "needed"), [(1e-6, 8), (1e-3, 26)])
def test_a_face_is_flat_to_a_thousandth_of_a_radian(height: float, needed: int) -> None:
    body = cut_box(1)
    # The middles of faces are lifted; what lies between them and corners bends with them.
    middles = np.sum(np.isclose(body.vertices, 0.0), axis=1) == 2
    assert middles.sum() == 6
    lifted = np.array(body.vertices)
    lifted[middles] *= 1.0 + height / np.linalg.norm(lifted[middles], axis=1, keepdims=True)
    found = needless_share(Surface(lifted, np.array(body.faces, np.int64)))
    assert found == pytest.approx(1 - needed / len(lifted))
