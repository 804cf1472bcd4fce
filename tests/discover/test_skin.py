"""Patches on a skin that is flat there, and on one that is not; the skin that a lamp lights."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
import trimesh
from lit_box import LAMP, MESH, run

from thermo.discover import Inclusion
from thermo.discover._skin import across_skin, flat_across, lit_skin, on_skin
from thermo.mesh import Mesh, box_mesh, face_centres, mesh_from_cells

HEIGHT = float(MESH.nodes.max(0)[2])


def patch(centre: tuple[float, float, float], size: tuple[float, float, float]) -> Inclusion:
    """A patch and another one elsewhere [m]."""
    return Inclusion(
        jnp.asarray([centre, (0.5, 0.5, 0.5)]), jnp.asarray([size, (0.1, 0.1, 0.1)]),
        jnp.full(2, 4.0), jnp.full(2, 8.0),
    )  # fmt: skip


def ball() -> Mesh:
    """Cells from the middle of a ball of 10 mm [m] to each of its faces."""
    made = trimesh.creation.icosphere(subdivisions=3, radius=0.01)
    nodes = np.vstack([[[0.0, 0.0, 0.0]], np.asarray(made.vertices)])
    cells = np.c_[np.zeros(len(made.faces), int), np.asarray(made.faces) + 1]
    return mesh_from_cells(nodes, cells, where="ball")


def test_a_patch_in_the_middle_of_a_side_is_held_across_it() -> None:
    fine = box_mesh((0.02, 0.012, 0.008), (20, 12, 8))
    place = patch((0.010, 0.006, 0.0078), (0.003, 0.002, 0.0005))
    np.testing.assert_array_equal(flat_across(place, 0, fine), [False, False, True])
    np.testing.assert_allclose(across_skin(place, 0, fine), [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(on_skin(place, 0, fine), [0.010, 0.006, 0.008])


def test_a_patch_that_goes_around_an_edge_of_the_body_is_not_held() -> None:
    fine = box_mesh((0.02, 0.012, 0.008), (20, 12, 8))
    place = patch((0.0195, 0.006, 0.0075), (0.003, 0.002, 0.0030))
    assert not flat_across(place, 0, fine).any()
    np.testing.assert_allclose(on_skin(place, 0, fine), [0.0195, 0.006, 0.0075])


@pytest.mark.parametrize(("deep", "held"), [(0.0007, False), (0.0002, True)])
def test_one_that_hangs_over_it_is_if_that_is_next_to_nothing(deep: float, held: bool) -> None:
    # A tenth of it around the edge tells how deep it reaches.
    fine = box_mesh((0.02, 0.012, 0.008), (20, 12, 8))
    place = patch((0.0175, 0.006, 0.0079), (0.003, 0.002, deep))
    share = np.asarray(place.only(0).shapes(jnp.asarray([[0.02, 0.006, 0.0079]])))
    assert share[0, 0] > 0.5
    np.testing.assert_array_equal(flat_across(place, 0, fine), [False, False, held])


def test_a_strip_around_an_edge_between_the_middles_of_faces_counts() -> None:
    # Their middles are 2 mm and more from that edge.
    coarse = box_mesh((0.02, 0.012, 0.012), (4, 2, 2))
    place = patch((0.0195, 0.006, 0.012), (0.003, 0.003, 0.0015))
    ends = face_centres(coarse)[coarse.normals[:, 0] > 0.9]
    assert float(place.only(0).shapes(jnp.asarray(ends)).max()) < 0.1
    assert not flat_across(place, 0, coarse).any()
    short = replace(place, centre=place.centre.at[0, 0].set(0.016))
    np.testing.assert_array_equal(flat_across(short, 0, coarse), [False, False, True])


@pytest.mark.parametrize(("wide", "held"), [(0.008, False), (0.0006, True)])
def test_on_a_round_skin_only_a_small_patch_is_held(wide: float, held: bool) -> None:
    place = patch((0.0, 0.0, 0.0099), (wide, wide, 0.002))
    np.testing.assert_array_equal(flat_across(place, 0, ball()), [False, False, held])


def test_a_patch_that_no_face_is_in_is_judged_by_those_that_are_nearest() -> None:
    fine = box_mesh((0.02, 0.012, 0.008), (20, 12, 8))
    off = patch((0.010, 0.006, 0.0060), (0.003, 0.002, 0.0017))
    share = np.asarray(off.only(0).shapes(jnp.asarray(fine.nodes[fine.faces[:, :3]].mean(1))))
    assert 0 < share.max() < 0.1
    assert flat_across(off, 0, fine)[2]


def test_another_part_has_its_own_skin() -> None:
    both = patch((0.010, 0.006, 0.0078), (0.003, 0.002, 0.0005))
    side = replace(both, centre=both.centre.at[1].set(jnp.asarray([0.0, 0.006, 0.004])))
    side = replace(side, size=side.size.at[1].set(jnp.asarray([0.0005, 0.003, 0.002])))
    fine = box_mesh((0.02, 0.012, 0.008), (20, 12, 8))
    np.testing.assert_array_equal(flat_across(side, 1, fine), [True, False, False])


def test_the_skin_that_a_lamp_lights_faces_it_and_is_near_its_axis() -> None:
    fine = box_mesh((0.02, 0.02, 0.008), (20, 20, 4))
    radius = 0.003
    above = LAMP | {"centre": [0.01, 0.01, 0.05], "direction": [0, 0, -2], "radius": radius}
    lit = lit_skin([run("lamp", lamp=above), run("cooling")], fine)
    far = np.hypot(*(lit[:, :2] - 0.01).T)
    np.testing.assert_allclose(lit[:, 2], 0.008, atol=1e-12)
    # A twentieth of the light is left at 2.45 radii.
    assert 2.2 * radius < far.max() < 2.46 * radius
    top = face_centres(fine)[fine.normals[:, 2] > 0.5]
    near = np.hypot(*(top[:, :2] - 0.01).T) < 2.4 * radius
    assert len(lit) >= near.sum() > 50
    # A second lamp adds what it lights, from the side here.
    beside = above | {"centre": [0.05, 0.01, 0.004], "direction": [-1, 0, 0]}
    both = lit_skin([run("lamp", lamp=above), run("other", lamp=beside)], fine)
    assert {tuple(one) for one in lit} < {tuple(one) for one in both}
    assert np.isclose(both[:, 0].max(), 0.02)
    assert len(lit_skin([run("cooling")], fine)) == 0
