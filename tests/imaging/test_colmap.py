"""Cameras of COLMAP's folders."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cameras import camera_at
from scipy.spatial.transform import Rotation

from thermo.errors import InputError
from thermo.imaging import Camera, project, read_cameras


def write_colmap(folder: Path, camera: Camera, model: str, numbers: list[float]) -> None:
    folder.mkdir()
    shown = " ".join(f"{one:.17g}" for one in numbers)
    (folder / "cameras.txt").write_text(
        f"1 {model} {camera.width} {camera.height} {shown}\n", "utf-8"
    )
    x, y, z, w = Rotation.from_matrix(camera.pose[:3, :3]).as_quat()
    pose = " ".join(f"{one:.17g}" for one in (w, x, y, z, *camera.pose[:3, 3]))
    (folder / "images.txt").write_text(f"1 {pose} 1 shots/a.png\n\n", "utf-8")
    (folder / "points3D.txt").write_text("", "utf-8")


def test_a_camera_of_colmap_projects_alike(tmp_path: Path) -> None:
    pytest.importorskip("pycolmap", reason="the extra thermofield[colmap] is not installed")
    bends = (-0.2, 0.05, 0.001, -0.002, 0.0)
    camera = camera_at((0.4, 0.3, 0.5), bends=bends)
    c_x, c_y = camera.centre + 0.5
    write_colmap(tmp_path / "0", camera, "OPENCV", [80.0, 80.0, c_x, c_y, *bends[:4]])
    (view,) = read_cameras(tmp_path / "0")
    assert view.file == "shots/a.png" and view.camera.name == "a"
    points = np.random.default_rng(0).uniform(-0.05, 0.05, (9, 3))
    assert np.abs(project(camera, points)[0] - project(view.camera, points)[0]).max() < 1e-9
    (far,) = read_cameras(tmp_path / "0", scale=10.0)
    np.testing.assert_allclose(far.camera.place(), 10 * camera.place(), atol=1e-12)


def test_other_lenses_and_folders_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("pycolmap", reason="the extra thermofield[colmap] is not installed")
    fish = [80.0, 80.0, 32.0, 24.0, 0.1, 0.0, 0.0, 0.0]
    write_colmap(tmp_path / "0", camera_at((1.0, 0.0, 0.0)), "OPENCV_FISHEYE", fish)
    with pytest.raises(InputError, match="lens is a fisheye") as caught:
        read_cameras(tmp_path / "0")
    assert "OPENCV_FISHEYE" in str(caught.value)
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="COLMAP folder cannot be read"):
        read_cameras(tmp_path / "empty")


def test_without_the_package_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pycolmap", None)
    with pytest.raises(InputError, match=r"thermofield\[colmap\]"):
        read_cameras(tmp_path)
