from __future__ import annotations

import numpy as np
import pytest
import trimesh

from thermo.mesh import Surface, caster_of, first_hits

BALL = trimesh.creation.icosphere(subdivisions=4)
SURFACE = Surface(np.asarray(BALL.vertices, float), np.asarray(BALL.faces))


@pytest.mark.parametrize("away", [1.5, 4.0, 1e4])
def test_rays_at_edges_and_vertices_meet_the_front(away: float) -> None:
    # Single precision alone lets a few of these through, to the back of the ball.
    ends = BALL.vertices[BALL.edges_unique]
    share = np.random.default_rng(0).random((len(ends), 1))
    aims = np.concatenate([ends[:, 0] * share + ends[:, 1] * (1 - share), BALL.vertices])
    place = away * np.array([3.0, 1.0, 0.5]) / np.linalg.norm([3.0, 1.0, 0.5])
    # In front of the horizon, by more than facets are inclined to the sphere.
    aims = aims[aims @ place > 1.0 + 0.1 * away]
    lines = aims - place
    length = np.linalg.norm(lines, axis=1)
    met = first_hits(caster_of(SURFACE), place, lines / length[:, None])
    assert len(aims) > 800
    np.testing.assert_allclose(met.distance, length, rtol=1e-9)
    np.testing.assert_allclose(met.weights.sum(axis=1), 1.0)
    assert met.weights.min() >= 0


def test_rays_from_inside_and_rays_that_miss() -> None:
    lines = np.array([[0.0, 0, 1], [np.nan, 0, 1]])
    inside = first_hits(caster_of(SURFACE), np.zeros(3), lines)
    assert inside.distance[0] == pytest.approx(1.0, abs=5e-3)
    assert inside.triangle[1] == -1 and np.isinf(inside.distance[1])
    beyond = first_hits(caster_of(SURFACE), np.array([0.0, 0, 3]), np.array([[0.0, 0, 1]]))
    assert beyond.triangle[0] == -1 and np.isnan(beyond.weights).all()


def test_rays_that_begin_each_at_its_own_place() -> None:
    random = np.random.default_rng(1)
    places, lines = 0.5 * random.normal(size=(2, 200, 3)) / np.sqrt(3)
    lines /= np.linalg.norm(lines, axis=1, keepdims=True)
    caster = caster_of(SURFACE)
    met = first_hits(caster, places, lines)
    for number in range(0, 200, 20):
        alone = first_hits(caster, places[number], lines[number : number + 1])
        assert alone.triangle[0] == met.triangle[number] >= 0
        assert alone.distance[0] == pytest.approx(met.distance[number], rel=1e-12)
