"""How well the scale is known of a surface that was brought to the cameras."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from thermo.app._brought import Brought, to_points, with_scale
from thermo.errors import InputError
from thermo.imaging import PointAlignment, Similarity, similarity_about
from thermo.mesh import Surface
from thermo.observe import read_scene

NO_SURFACE = Surface(np.zeros((0, 3)), np.zeros((0, 3), np.int64))


def brought(deviation: float, untold: tuple[str, ...] = ()) -> Brought:
    known = np.array([*(6 * [1e-3]), deviation])
    found = PointAlignment(Similarity(), 1e-4, 0.95, known, untold, True, "")
    return Brought(NO_SURFACE, found, [])


def test_scales_that_are_known_in_two_ways_add_in_squares(block: Path) -> None:
    rebuilt = replace(read_scene(block), scale_deviation=0.03)
    free = {"align": "pose_and_scale", "scale_deviation": None}
    assert with_scale(free, rebuilt, brought(0.04)).scale_deviation == pytest.approx(0.05)
    assert with_scale(free, read_scene(block), brought(0.04)).scale_deviation == 0.04
    for settings in ({**free, "align": "pose"}, {**free, "scale_deviation": 0.03}):
        kept = with_scale(settings, rebuilt, brought(2.0, ("scale",)))
        assert kept.scale_deviation == 0.03


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (brought(0.2, ("scale and distance together",)), "scale and distance together"),
        (brought(0.6), "known to 60 %"),
    ],
)
def test_a_scale_that_nothing_tells_is_refused(block: Path, found: Brought, said: str) -> None:
    free = {"align": "pose_and_scale", "scale_deviation": None}
    with pytest.raises(InputError, match="the scale is not told") as caught:
        with_scale(free, read_scene(block), found)
    assert said in str(caught.value) and "align=pose" in str(caught.value)


def test_what_points_leave_free_is_said() -> None:
    rod = trimesh.creation.cylinder(radius=0.02, height=0.07, sections=64)
    surface = Surface(np.asarray(rod.vertices), np.asarray(rod.faces, np.int64))
    random = np.random.default_rng(0)
    points = trimesh.sample.sample_surface(rod, 30_000, seed=random)[0]  # of which some are drawn
    points += 1e-4 * random.standard_normal(points.shape)
    away = similarity_about(np.zeros(3), np.array([0.05, 0.03, 0.4, 1e-3, 2e-3, -1e-3, 0.0]))
    brought = to_points({"align": "pose", "points": "a.ply"}, surface, away.apply(points))
    assert "not told by the points: rotation about [" in brought.words[2]
    assert "scale to" not in brought.words[1] and len(brought.words) == 3
    # Their turn about the axis may be any: the ends of the axis are where they belong.
    ends = np.array([[0.0, 0.0, -0.035], [0.0, 0.0, 0.035]])
    np.testing.assert_allclose(brought.found.similarity.apply(ends), away.apply(ends), atol=1e-4)
