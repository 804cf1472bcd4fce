"""The nearest of many triangles."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.mesh import nearest_triangle
from thermo.mesh._nearest import closest_on_triangles
from thermo.mesh._nearest_triangle import MOST_CUTS, _cut


def drawn(rng: np.random.Generator, shape: str) -> np.ndarray:
    """Forty triangles of sizes that differ a thousandfold, or needles as long as the whole."""
    corners = rng.normal(size=(40, 3, 3))
    if shape == "needles":
        corners[:, 2] = corners[:, 1] + 1e-3 * rng.normal(size=(40, 3))
        return corners
    sizes = 10.0 ** rng.uniform(-3, 0, size=(40, 1, 1))
    return rng.normal(size=(40, 1, 3)) + sizes * corners


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["unequal", "needles"]))
def test_none_of_all_triangles_is_nearer(seed: int, shape: str) -> None:
    rng = np.random.default_rng(seed)
    corners = drawn(rng, shape)
    weight = rng.dirichlet([1.0, 1.0, 1.0], size=60)
    on = np.einsum("sk,ski->si", weight, corners[rng.integers(40, size=60)])
    points = on + 10.0 ** rng.uniform(-6, 1, size=(60, 1)) * rng.normal(size=(60, 3))
    face, weights, distance = nearest_triangle(corners, points)
    _, every = closest_on_triangles(np.tile(corners, (60, 1, 1, 1)), points[:, None])
    np.testing.assert_allclose(distance, every.min(axis=1), rtol=1e-12, atol=1e-12)
    foot = np.einsum("sk,ski->si", weights, corners[face])
    np.testing.assert_allclose(np.linalg.norm(points - foot, axis=1), distance, atol=1e-10)
    assert (weights > -1e-12).all()
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-12)


def brute(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distance by dense sampling and refinement of every triangle (an upper bound)."""
    i, j = np.meshgrid(np.arange(41), np.arange(41), indexing="ij")
    keep = i + j <= 40
    first, second = i[keep] / 40, j[keep] / 40
    weights = np.stack([1 - first - second, first, second], axis=1)
    cloud = np.einsum("qk,tki->tqi", weights, corners).reshape(-1, 3)
    return np.array([np.linalg.norm(cloud - p, axis=1).min() for p in points])


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_nearest_triangle_is_the_nearest_among_unequal_ones(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sizes = 10.0 ** rng.uniform(-3, 0, size=(40, 1, 1))
    corners = rng.normal(size=(40, 1, 3)) + sizes * rng.normal(size=(40, 3, 3))
    points = rng.normal(size=(12, 3)) * 2
    face, weights, distance = nearest_triangle(corners, points)
    assert (weights > -1e-12).all()
    foot = np.einsum("sk,ski->si", weights, corners[face])
    np.testing.assert_allclose(np.linalg.norm(points - foot, axis=1), distance, atol=1e-12)
    dense = brute(corners, points)
    assert (distance <= dense + 1e-12).all()
    spacing = np.linalg.norm(np.diff(corners, axis=1), axis=2).max() / 40
    assert (dense - distance <= spacing).all()


@pytest.mark.parametrize("shape", ["unequal", "needles"])
def test_pieces_cover_their_triangles_and_are_small(shape: str) -> None:
    corners = drawn(np.random.default_rng(0), shape)
    owner, pieces = _cut(corners, 2000)
    assert 40 < len(pieces) <= MOST_CUTS * 2000

    def areas(some: np.ndarray) -> np.ndarray:
        apart = np.cross(some[:, 1] - some[:, 0], some[:, 2] - some[:, 0])
        return 0.5 * np.linalg.norm(apart, axis=1)

    covered = np.bincount(owner, areas(pieces), minlength=40)
    np.testing.assert_allclose(covered, areas(corners), rtol=1e-9)
    _, off = closest_on_triangles(corners[owner], pieces.mean(axis=1))
    np.testing.assert_allclose(off, 0.0, atol=1e-10)
    longest = np.linalg.norm(np.diff(pieces, axis=1), axis=2).max()
    assert longest < 0.5 * np.linalg.norm(np.diff(corners, axis=1), axis=2).max()


def test_triangles_without_area_and_no_points() -> None:
    line = np.array([[[0.0, 0, 0], [1, 0, 0], [2, 0, 0]], [[3.0, 0, 0], [3, 0, 0], [3, 0, 0]]])
    face, _, distance = nearest_triangle(line, np.array([[1.5, 1.0, 0.0], [4.0, 0.0, 0.0]]))
    np.testing.assert_array_equal(face, [0, 1])
    np.testing.assert_allclose(distance, 1.0)
    face, weights, distance = nearest_triangle(line, np.zeros((0, 3)))
    assert face.shape == distance.shape == (0,)
    assert weights.shape == (0, 3)
