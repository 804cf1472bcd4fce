"""Fields on another mesh: the same values, those of the nearest, medians, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.fields import Boundary, two_material_values
from thermo.inverse import Estimate, RecoveredField, load_estimate, save_estimate
from thermo.inverse._properties import Stated
from thermo.inverse._transfer import SAME, carry_over, check_same_object, medians
from thermo.mesh import Mesh, Surface, box_mesh, face_areas, promote

SIZE = (0.04, 0.02, 0.02)
COARSE = box_mesh(SIZE, (8, 4, 4))
FINE = box_mesh(SIZE, (14, 7, 7))
PLANE = 0.02
OFFSETS = st.floats(-1e-3, 1e-3)


def cell_centres(mesh: Mesh) -> np.ndarray:
    return mesh.nodes[mesh.cells[:, :4]].mean(1)


def face_centres(mesh: Mesh) -> np.ndarray:
    return mesh.nodes[mesh.faces[:, :3]].mean(1)


def recovered(cells: np.ndarray, faces: np.ndarray) -> RecoveredField:
    return RecoveredField("conductivity", "W/m/K", cells.astype(float), faces.astype(float))


def noise(mesh: Mesh, seed: int) -> RecoveredField:
    make = np.random.default_rng(seed)
    return recovered(make.uniform(size=len(mesh.cells)), make.uniform(size=len(mesh.faces)))


def numbered(mesh: Mesh) -> RecoveredField:
    return recovered(np.arange(len(mesh.cells)), np.arange(len(mesh.faces)))


def two_valued(mesh: Mesh) -> RecoveredField:
    return recovered(
        np.where(cell_centres(mesh)[:, 0] < PLANE, 1.0, 4.0),
        np.where(face_centres(mesh)[:, 0] < PLANE, 1.0, 4.0),
    )


def test_the_same_mesh_keeps_every_bit() -> None:
    fields = {"conductivity": noise(COARSE, 0), "convection": noise(COARSE, 1)}
    got = carry_over(fields, COARSE, COARSE)
    assert set(got) == set(fields)
    for name, field in fields.items():
        np.testing.assert_array_equal(got[name][0], field.cells)
        np.testing.assert_array_equal(got[name][1], field.faces)


def test_quadratic_cells_take_what_linear_ones_take() -> None:
    fields = {"conductivity": noise(COARSE, 2)}
    plain = carry_over(fields, COARSE, FINE)["conductivity"]
    curved = carry_over(fields, COARSE, promote(FINE))["conductivity"]
    for mine, theirs in zip(plain, curved, strict=True):
        np.testing.assert_array_equal(mine, theirs)


@pytest.mark.parametrize(("old", "new"), [(COARSE, FINE), (FINE, COARSE)])
def test_two_values_stay_what_they_are_away_from_their_boundary(old: Mesh, new: Mesh) -> None:
    got = carry_over({"conductivity": two_valued(old)}, old, new)["conductivity"]
    for values, centres in zip(got, (cell_centres(new), face_centres(new)), strict=True):
        away = centres[:, 0] - PLANE
        far = np.abs(away) > SIZE[0] / 8
        assert far.mean() > 0.5
        np.testing.assert_array_equal(values[far], np.where(away[far] < 0, 1.0, 4.0))
        assert set(values) == {1.0, 4.0}


@pytest.mark.parametrize(("old", "new"), [(COARSE, FINE), (FINE, COARSE)])
def test_the_nearest_cell_and_face_give_the_value(old: Mesh, new: Mesh) -> None:
    cells, faces = carry_over({"convection": numbered(old)}, old, new)["convection"]
    apart = np.linalg.norm(cell_centres(new)[:, None] - cell_centres(old)[None], axis=2)
    taken = apart[np.arange(len(cells)), cells.astype(int)]
    np.testing.assert_allclose(taken, apart.min(1), rtol=1e-9)
    # On the flat sides of a box the face lies on the same side, and is the nearest one there.
    same = (new.normals @ old.normals.T) > 0.99
    apart = np.linalg.norm(face_centres(new)[:, None] - face_centres(old)[None], axis=2)
    picked = faces.astype(int)
    assert same[np.arange(len(picked)), picked].all()
    taken = apart[np.arange(len(picked)), picked]
    np.testing.assert_allclose(taken, np.where(same, apart, np.inf).min(1), rtol=1e-9)


def test_the_rim_of_a_thin_plate_does_not_take_the_values_of_its_side() -> None:
    coarse, fine = (box_mesh((0.04, 0.04, 0.002), (n, n, 1)) for n in (5, 20))
    faces = np.where(coarse.normals[:, 2] > 0.9, 1.0, 0.0)
    field = RecoveredField("convection", "W/m2/K", np.zeros(len(coarse.cells)), faces)
    found = carry_over({"convection": field}, coarse, fine)["convection"][1]
    np.testing.assert_array_equal(found, np.where(fine.normals[:, 2] > 0.9, 1.0, 0.0))


def surface_of(mesh: Mesh) -> Surface:
    return Surface(mesh.nodes, mesh.faces)


def other_size() -> Mesh:
    return box_mesh((0.042, 0.02, 0.02), (8, 4, 4))


def other_place() -> Mesh:
    return box_mesh(SIZE, (8, 4, 4), origin=(0.0, -0.003, 0.0))


@pytest.mark.parametrize(
    ("new", "apart", "limit"),
    [(other_size(), "2 mm", "0.506 mm, 1% of"), (other_place(), "3 mm", "0.49 mm, 1% of")],
)
def test_another_object_is_refused_with_the_numbers(new: Mesh, apart: str, limit: str) -> None:
    with pytest.raises(InputError) as caught:
        check_same_object(COARSE, surface_of(new), "fits/bracket")
    error = caught.value
    assert error.where == "fits/bracket"
    assert str(error.value).endswith(f" {apart}")
    assert error.limit.startswith(limit)
    assert "surface that was fitted" in error.remedy
    assert len(str(error).splitlines()) == 4


@given(offset=st.tuples(OFFSETS, OFFSETS, OFFSETS))
def test_only_what_lies_further_apart_than_the_limit_is_refused(
    offset: tuple[float, float, float],
) -> None:
    old, new = box_mesh(SIZE, (2, 1, 1)), box_mesh(SIZE, (2, 1, 1), origin=offset)
    apart, limit = np.abs(offset).max(), SAME * np.linalg.norm(SIZE)
    assume(abs(apart - limit) > 1e-9)
    fields = {"conductivity": two_valued(old)}
    if apart < limit:
        check_same_object(old, surface_of(new), "estimate")
        got = carry_over(fields, old, new)["conductivity"]
        np.testing.assert_array_equal(got[0], fields["conductivity"].cells)
    else:
        with pytest.raises(InputError, match="another size or place"):
            check_same_object(old, surface_of(new), "estimate")


def plate() -> tuple[Mesh, np.ndarray]:
    """A plate whose two wide sides have few faces, and which faces are on them."""
    mesh = box_mesh((0.02, 0.02, 0.002), (2, 2, 6))
    height = face_centres(mesh)[:, 2]
    return mesh, (height < 1e-9) | (height > 0.002 - 1e-9)


def test_the_median_is_by_area_and_everywhere() -> None:
    old, wide = plate()
    faces = np.where(wide, 3.0, 1.0)
    assert np.median(faces) == 1.0
    fields = {"convection": recovered(np.full(len(old.cells), 9.0), faces)}
    cells, sides = medians(fields, old, FINE)["convection"]
    np.testing.assert_array_equal(cells, np.full(len(FINE.cells), 3.0))
    np.testing.assert_array_equal(sides, np.full(len(FINE.faces), 3.0))


@given(seed=st.integers(0, 1000))
def test_half_of_the_area_lies_below_the_median(seed: int) -> None:
    old, _ = plate()
    field, areas = noise(old, seed), face_areas(old)
    middle = medians({"convection": field}, old, old)["convection"][1][0]
    for part in (field.faces < middle, field.faces > middle):
        bound = 0.5 * areas.sum() + 0.5 * areas.max()
        assert areas[part].sum() <= bound * (1 + 1e-12)


def test_two_materials_are_laid_out_anew_and_survive_their_file(tmp_path: Path) -> None:
    old, new = box_mesh(SIZE, (8, 4, 4)), box_mesh(SIZE, (16, 6, 6))
    points = old.nodes[np.unique(old.faces)]
    boundary = Boundary(points, points[:, 0] - 0.017, np.array([1.0, 4.0]))
    cells, faces = two_material_values(boundary, old)
    field = RecoveredField("conductivity", "W/m/K", cells, faces, boundary)
    found = carry_over({"conductivity": field}, old, new)["conductivity"]
    for mine, theirs in zip(found, two_material_values(boundary, new), strict=True):
        np.testing.assert_array_equal(mine, theirs)
    # A plane boundary stays plane; six half edges from it the value is that of the material.
    along = cell_centres(new)[:, 0]
    assert np.allclose(np.asarray(found[0])[along > 0.025], 4.0, rtol=1e-3)
    assert np.allclose(np.asarray(found[0])[along < 0.010], 1.0, rtol=1e-3)
    stated = Stated(1.0, 2e6, 8.0, 0.9)
    fields = {"conductivity": field}
    fit = Estimate(old, 2, stated, fields, {}, [[1.0]], True, 1.0, "well resolved", {})
    save_estimate(tmp_path / "estimate.npz", fit)
    again = load_estimate(tmp_path / "estimate.npz")[3]["conductivity"].boundary
    assert again is not None
    for part in ("points", "heights", "levels"):
        np.testing.assert_array_equal(getattr(again, part), getattr(boundary, part))
