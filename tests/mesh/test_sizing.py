"""Cell sizes from physics, and how well they resolve it."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from thermo.errors import InputError
from thermo.mesh import (
    Fine,
    Sizing,
    Surface,
    box_mesh,
    expected_nodes,
    heat_depth,
    promote,
    resolution,
    sizing_from_physics,
)
from thermo.mesh._node_count import shape_of
from thermo.mesh._sizing_field import sizing_field, surface_cloud
from thermo.mesh._thickness import inward_rays

from .conftest import as_surface


def test_depth_of_the_plastic_bunny():
    assert heat_depth(1.3e-7, 60.0) == pytest.approx(2.79e-3, rel=1e-2)


def test_a_poor_conductor_gets_a_fine_skin_and_a_coarse_inside(cube):
    sizing = sizing_from_physics(cube, diffusivity=1.3e-7, duration=60.0)
    assert sizing.skin == pytest.approx(heat_depth(1.3e-7, 60.0), rel=1e-6)
    assert sizing.core > 1.5 * sizing.skin
    finer = sizing_from_physics(cube, diffusivity=1.3e-7, duration=60.0, cells_per_depth=1.5)
    assert finer.skin < sizing.skin


@pytest.mark.parametrize("tolerance", [None, 4e-5])
def test_a_divided_sizing_is_finer_all_over(tolerance):
    whole = Sizing(4e-3, 8e-3, 5e-3, tolerance)
    half = whole.divided(2.0)
    assert (half.skin, half.core, half.depth) == (2e-3, 4e-3, 5e-3)
    assert half.tolerance == (None if tolerance is None else tolerance / 2)


def test_a_good_conductor_gets_a_few_cells_across(cube):
    sizing = sizing_from_physics(cube, diffusivity=1e-4, duration=60.0)
    assert sizing.core == pytest.approx(cube.diagonal() / 12)
    assert expected_nodes(cube, sizing) < 10000


@settings(max_examples=30, deadline=None)
@given(st.floats(1e-9, 1e-3), st.floats(0.1, 1e4), st.integers(500, 50000))
def test_the_estimate_stays_below_the_cap(diffusivity, duration, most):
    plate = as_surface(trimesh.creation.box((0.08, 0.08, 0.004)))
    sizing = sizing_from_physics(plate, diffusivity=diffusivity, duration=duration, max_nodes=most)
    assert expected_nodes(plate, sizing) <= most
    assert 0 < sizing.skin <= sizing.core


def rippled(half, subdivisions=5):
    """An ellipsoid of half axes [m] with ripples of a fortieth of the first."""
    ball = trimesh.creation.icosphere(subdivisions)
    bumps = 1 + np.sin(12 * ball.vertices).prod(axis=1) / 40
    ball.vertices *= bumps[:, None] * np.asarray(half)
    return as_surface(ball)


def test_a_loose_tolerance_is_given_for_nodes_on_a_detailed_surface():
    surface = rippled((0.04, 0.04, 0.04))
    asked = {"diffusivity": 1e-6, "duration": 60.0}
    most = (1e6, 20000, 6000)
    found = [sizing_from_physics(surface, **asked, max_nodes=int(one)) for one in most]
    tolerances = [one.tolerance / surface.diagonal() for one in found]
    assert tolerances[:2] == pytest.approx([5e-4, 7e-4])
    assert 1e-3 < tolerances[2] <= 2e-3
    nodes = [expected_nodes(surface, one) for one in found]
    assert 20000 < nodes[1] < 50000 and nodes[2] < 15000


def test_a_thin_body_keeps_its_sides_apart():
    surface = rippled((0.04, 0.04, 4e-4))
    sizing = sizing_from_physics(surface, diffusivity=1e-6, duration=60.0, max_nodes=1500)
    assert expected_nodes(surface, sizing) > 2.5 * 1500, "it would be loosened if it were thick"
    assert sizing.tolerance <= 7.001e-4 * surface.diagonal()


def test_thickness_of_a_plate_and_a_ball(ball):
    plate = as_surface(trimesh.creation.box((0.08, 0.08, 0.004)).subdivide().subdivide())
    assert np.quantile(inward_rays(plate).lengths, 0.05) == pytest.approx(0.004)
    np.testing.assert_allclose(inward_rays(ball).lengths, 0.05, rtol=0.1)


def test_field_is_skin_on_the_surface_and_core_inside(cube):
    sizing = Sizing(skin=0.002, core=0.006, depth=0.008)
    nodes, cells, values = sizing_field(cube, sizing)
    assert cells.max() < len(nodes) == len(values)
    distance = np.abs(0.02 - np.abs(nodes).max(axis=1))
    inside = (np.abs(nodes) < 0.02).all(axis=1)
    np.testing.assert_allclose(values[inside & (distance < 5e-4)], 0.002, rtol=0.1)
    np.testing.assert_allclose(values[inside & (distance > 0.010)], 0.006)
    assert values.min() >= 0.002 and values.max() <= 0.006


def test_a_surface_that_is_read_again_is_not_measured_again(cube, ball):
    again = Surface(cube.vertices.copy(), cube.triangles.copy())
    assert shape_of(again) is shape_of(cube)
    wider = Surface(1.001 * cube.vertices, cube.triangles)
    assert shape_of(wider).diagonal == pytest.approx(1.001 * shape_of(cube).diagonal, rel=1e-12)
    assert len(shape_of(ball).areas) == len(ball.triangles)


def test_the_field_is_fine_where_it_is_asked_for_and_grows_from_there(cube):
    spots = np.array([[0.0, 0.0, 0.0], [0.008, 0.0, 0.0]])
    usual = Sizing(skin=0.004, core=0.008, depth=0.002)
    sizing = replace(usual, fine=(Fine(spots, 0.001),))
    nodes, _, values = sizing_field(cube, sizing)
    away, _ = KDTree(spots).query(nodes)
    assert (values[away <= 0.001] == 0.001).all() and (away <= 0.001).any()
    assert (values <= 0.001 + 0.5 * away).all() and values.max() <= 0.008
    assert values[away > 0.016].min() >= 0.004
    half = sizing.divided(2.0)
    assert half.fine[0].edge == 0.0005 and half.skin == 0.002


@pytest.mark.parametrize(("count", "edge"), [(1, 0.0), (1, np.nan), (1, -1e-3), (0, 1e-3)])
def test_nowhere_to_be_fine_is_refused(count, edge):
    with pytest.raises(InputError, match="sizing.fine"):
        Fine(np.zeros((count, 3)), edge)


def test_cloud_leaves_no_gap(cube):
    rng = np.random.default_rng(0)
    spots = rng.uniform(-0.02, 0.02, size=(500, 3))
    spots[np.arange(500), rng.integers(3, size=500)] = 0.02
    gap, _ = KDTree(surface_cloud(cube, 0.001)).query(spots)
    assert gap.max() < 0.001


@pytest.mark.parametrize("values", [(0.0, 1, 1), (1, 0.5, 1), (1, 1, np.nan), (-1, 1, 1)])
def test_senseless_sizings_are_refused(values):
    with pytest.raises(InputError, match="sizing"):
        Sizing(*values)


@pytest.mark.parametrize(
    "change",
    [
        {"diffusivity": 0.0},
        {"diffusivity": np.nan},
        {"duration": -1.0},
        {"cells_per_depth": 0.0},
        {"max_nodes": 0},
    ],
)
def test_senseless_physics_is_refused(cube, change):
    good = {"diffusivity": 1e-6, "duration": 60.0}
    with pytest.raises(InputError, match=next(iter(change))):
        sizing_from_physics(cube, **(good | change))


def test_resolution_counts_cells_and_says_so():
    mesh = box_mesh((0.04, 0.04, 0.04), (6, 6, 6))
    found = resolution(mesh, diffusivity=1e-6, duration=100.0)
    assert found.depth == pytest.approx(0.01)
    assert 0.04 / 6 <= found.skin_edge <= 0.04 / 6 * np.sqrt(3)
    assert found.cells_per_depth == pytest.approx(found.depth / found.skin_edge)
    assert "10.0 mm deep" in found.describe() and "well resolved" not in found.describe()
    assert resolution(promote(mesh), diffusivity=1e-6, duration=100.0) == found
    assert "well" in resolution(mesh, diffusivity=1e-6, duration=1000.0).describe()
    assert "too coarse" in resolution(mesh, diffusivity=1e-6, duration=1.0).describe()


def test_a_smooth_ball_needs_more_nodes_for_a_tighter_tolerance():
    fine = as_surface(trimesh.creation.icosphere(subdivisions=4, radius=0.025))
    tight, loose = (
        expected_nodes(fine, Sizing(0.007, 0.007, 0.05, tolerance)) for tolerance in (2e-5, 2e-4)
    )
    assert tight > 2 * loose
    assert Sizing(0.007, 0.007, 0.05).envelope(fine) == pytest.approx(5e-4 * fine.diagonal())
    with pytest.raises(InputError, match="tolerance"):
        Sizing(0.007, 0.007, 0.05, 0.0)


def test_a_cap_below_what_the_curved_sides_need_still_ends():
    fine = as_surface(trimesh.creation.icosphere(subdivisions=4, radius=0.025))
    sizing = sizing_from_physics(fine, diffusivity=1e-6, duration=60.0, max_nodes=200)
    assert sizing.skin < fine.diagonal()
