"""Clouds of points: files of all kinds, and clouds that cannot show an object."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from thermo.errors import InputError
from thermo.imaging import check_cloud, read_points
from thermo.mesh import Surface

POINTS = np.random.default_rng(0).uniform(-40.0, 60.0, size=(30, 3))


def text(points: np.ndarray, separator: str = " ") -> str:
    return "\n".join(separator.join(f"{one:.9g}" for one in row) for row in points) + "\n"


def written(folder: Path, name: str) -> Path:
    path = folder / name
    match name.partition(".")[2]:
        case "ply":
            trimesh.PointCloud(POINTS).export(path)
        case "xyz":
            path.write_text("# x y z red green blue\n" + text(np.c_[POINTS, 0 * POINTS]))
        case "csv":
            path.write_text("x,y,z,intensity\n" + text(np.c_[POINTS, POINTS[:, 0]], ","))
        case "npy":
            np.save(path, POINTS)
        case _:
            np.savez(path, points=POINTS, colours=POINTS)
    return path


@pytest.mark.parametrize("name", ["a.ply", "a.xyz", "a.csv", "a.npy", "a.npz"])
def test_points_of_all_kinds_of_files(tmp_path: Path, name: str) -> None:
    path = written(tmp_path, name)
    # A PLY of trimesh's holds single precision.
    np.testing.assert_allclose(read_points(path, unit="mm"), POINTS / 1000, atol=1e-8)
    np.testing.assert_allclose(read_points(path, unit=0.5), POINTS / 2, atol=1e-5)


def test_vertices_of_a_surface_are_points(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(subdivisions=2, radius=3.0)
    ball.export(tmp_path / "ball.ply")
    found = read_points(tmp_path / "ball.ply", unit="cm")
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 0.03, rtol=1e-6)


def test_units_in_a_header_are_those_that_are_stated(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("x_mm;y [mm];z_mm\n" + text(POINTS, ";").replace(".", ","))
    np.testing.assert_allclose(read_points(path, unit="mm"), POINTS / 1000, rtol=1e-6)
    with pytest.raises(InputError, match="another unit") as caught:
        read_points(path, unit="m")
    assert "x_mm" in str(caught.value)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.ply", b"", "no file of points"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 90\n", "no file of points"),
        ("a.xyz", b"1 2 3\n4 5\n", "no file of points"),
        ("a.xyz", b"a b c\n", "no file of points"),
        ("a.txt", text(POINTS[:, :2]).encode(), "shape (30, 2)"),
        ("a.csv", text(POINTS, ",").encode(), "no header"),
        ("a.csv", b"x,y,temperature\n1,2,3\n", "columns x, y, temperature"),
        ("a.npy", b"\x93NUMPY", "no file of points"),
        ("a.npz", b"PK", "not a whole NPZ file"),
        ("a.las", b"LASF", "ends in .las"),
        ("a", b"", "ends in nothing"),
        ("a.xyz", text(POINTS[:11]).encode(), "at least 12 points"),
        ("a.xyz", (text(POINTS) + "1 nan 2\n").encode(), "1 points, the first is point 30"),
    ],
)
def test_what_holds_no_points_is_refused(
    tmp_path: Path, name: str, content: bytes, said: str
) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        read_points(path, unit="mm")
    assert said in str(caught.value) and path.name in str(caught.value)


def test_units_and_files_that_are_not_there(tmp_path: Path) -> None:
    for unit, said in (("ft", "m, cm, mm, inch"), (0.0, "above 0"), (np.nan, "length of the unit")):
        with pytest.raises(InputError) as caught:
            read_points(tmp_path / "a.ply", unit=unit)
        assert said in str(caught.value)
    with pytest.raises(InputError, match="no such file"):
        read_points(tmp_path / "a.ply", unit="m")
    np.save(tmp_path / "objects.npy", np.array([{}] * 12, object), allow_pickle=True)
    with pytest.raises(InputError, match="no file of points"):
        read_points(tmp_path / "objects.npy", unit="m")


def block() -> tuple[Surface, np.ndarray]:
    mesh = trimesh.creation.box(extents=(0.03, 0.05, 0.08))
    points = trimesh.sample.sample_surface(mesh, 400, seed=0)[0]
    return Surface(np.asarray(mesh.vertices), np.asarray(mesh.faces, np.int64)), points


@settings(max_examples=30)
@given(st.sampled_from([1000.0, 100.0, 10.0, 25.4, 39.37]), st.booleans(), st.floats(0, 6.2))
def test_clouds_in_another_unit_are_told(factor: float, less: bool, turn: float) -> None:
    surface, points = block()
    turned = points @ np.array(
        [[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    )
    check_cloud(surface, turned, where="a.ply")
    with pytest.raises(InputError, match="another size") as caught:
        check_cloud(surface, turned / factor if less else turned * factor, where="a.ply")
    assert "a.ply" in str(caught.value) and "times its size" in str(caught.value)


def test_parts_and_strays_are_no_fault_but_another_place_is() -> None:
    surface, points = block()
    check_cloud(surface, points[points[:, 2] > 0.02], where="a.ply")
    strays = np.random.default_rng(0).uniform(-2, 2, size=(300, 3))
    check_cloud(surface, np.concatenate([points, strays]), where="a.ply")
    with pytest.raises(InputError, match="elsewhere") as caught:
        check_cloud(surface, points + [0.0, 0.3, 0.0], where="a.ply")
    assert "0 % of them" in str(caught.value) and "[" in str(caught.value)
    many = np.random.default_rng(0).uniform(-2, 2, size=(3000, 3))
    with pytest.raises(InputError, match="another size") as caught:
        check_cloud(surface, np.concatenate([points, many]), where="a.ply")
    assert "cut away" in str(caught.value)


@pytest.mark.parametrize(
    ("times", "words"),
    [(1000.0, "as if m stood for mm; "), (10.0, "as if cm stood for mm; "),
     (0.001, "as if mm stood for m; "), (30.0, "")],
)  # fmt: skip
def test_the_unit_that_was_taken_for_another_is_told(times: float, words: str) -> None:
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.03)
    surface = Surface(np.asarray(ball.vertices), np.asarray(ball.faces, dtype=np.int64))
    with pytest.raises(InputError) as caught:
        check_cloud(surface, times * surface.vertices, where="cloud.ply")
    assert f"its size: {words}state another unit" in caught.value.remedy
