"""Coarser spaces of a mesh: when there are any, and that they carry what they should."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thermo.mesh import box_mesh, promote
from thermo.physics import _coarse_spaces, discretise
from thermo.physics._coarse_spaces import CoarseSpaces, halved

LINEAR = box_mesh((0.02, 0.02, 0.01), (6, 6, 3))
FAR = 1.0
"""Reach [m2] that crosses the body many times over."""


def made(order: int, monkeypatch: pytest.MonkeyPatch) -> tuple[CoarseSpaces, np.ndarray]:
    monkeypatch.setattr(_coarse_spaces, "LEAST_NODES", 0)
    space = discretise(LINEAR if order == 1 else promote(LINEAR), FAR)
    assert space.coarse is not None
    return space.coarse, np.asarray(space.mesh.nodes)


def test_there_are_none_for_small_meshes_and_short_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    assert discretise(LINEAR, FAR).coarse is None
    monkeypatch.setattr(_coarse_spaces, "LEAST_NODES", 0)
    assert discretise(LINEAR).coarse is None
    assert discretise(LINEAR, 1e-6).coarse is None
    assert discretise(LINEAR, FAR).coarse is not None


@pytest.mark.parametrize("order", [1, 2])
def test_what_is_linear_is_carried_from_the_corners_to_all_nodes(
    order: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    spaces, nodes = made(order, monkeypatch)
    corner = np.empty((len(spaces.part), 3))
    ends = np.arange(len(nodes))[:, None] if spaces.ends is None else np.asarray(spaces.ends)
    own = ends[:, 0] == ends[:, -1]
    corner[ends[own, 0]] = nodes[own]
    assert own.sum() == len(corner)
    np.testing.assert_allclose(spaces.nodes(jnp.asarray(corner)), nodes, atol=1e-15)


@pytest.mark.parametrize("order", [1, 2])
def test_heat_is_shared_out_by_the_transpose(order: int, monkeypatch: pytest.MonkeyPatch) -> None:
    spaces, nodes = made(order, monkeypatch)
    make = np.random.default_rng(order)
    heat = jnp.asarray(make.normal(size=(len(nodes), 2)))
    warmth = jnp.asarray(make.normal(size=(len(spaces.part), 2)))
    shared, carried = spaces.corners(heat), spaces.nodes(warmth)
    np.testing.assert_allclose(jnp.sum(shared * warmth, 0), jnp.sum(heat * carried, 0))
    np.testing.assert_allclose(shared.sum(0), heat.sum(0))
    sums = spaces.sums(shared)
    assert sums.shape == (spaces.parts, 2)
    for part in range(spaces.parts):
        np.testing.assert_allclose(sums[part], shared[np.asarray(spaces.part) == part].sum(0))


@given(st.integers(0, 150), st.integers(0, 6), st.integers(0, 2**32 - 1))
def test_parts_are_as_large_as_each_other(beyond: int, times: int, seed: int) -> None:
    count = 2**times + beyond
    points = np.random.default_rng(seed).normal(size=(count, 3)) * [3.0, 1.0, 0.1]
    size = np.bincount(halved(points, times), minlength=2**times)
    assert len(size) == 2**times and size.sum() == count and np.ptp(size) <= 1


def test_parts_lie_apart_along_a_bar() -> None:
    along = np.random.default_rng(0).permutation(64)
    part = halved(np.stack([along, 0.1 * (along % 3), 0.1 * (along % 2)], 1) * 1e-3, 3)
    np.testing.assert_array_equal(part, along // 8)
