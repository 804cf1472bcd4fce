"""Surfaces from files."""

import numpy as np
import pytest
import trimesh

from thermo.errors import InputError
from thermo.mesh import read_surface


@pytest.mark.parametrize("suffix", ["stl", "ply", "obj", "off"])
def test_formats_and_units(tmp_path, suffix):
    path = tmp_path / f"ball.{suffix}"
    trimesh.creation.icosphere(subdivisions=2, radius=25.0).export(path)
    surface = read_surface(path, unit="mm")
    np.testing.assert_allclose(np.ptp(surface.vertices, axis=0), 0.05, rtol=1e-5)
    assert len(surface.triangles) == 320
    assert surface.volume() > 0


def test_millimetres_taken_for_metres_name_the_remedy(tmp_path):
    path = tmp_path / "cube.stl"
    trimesh.creation.box((40, 40, 40)).export(path)
    with pytest.raises(InputError, match="unit=mm") as refusal:
        read_surface(path)
    assert str(path) in str(refusal.value)


def write(path, content):
    path.write_bytes(content)
    return path


def test_unreadable_files_are_refused(tmp_path):
    good = tmp_path / "good.ply"
    trimesh.creation.box((1, 1, 1)).export(good)
    cases = [
        tmp_path / "missing.ply",
        tmp_path,
        write(tmp_path / "empty.ply", b""),
        write(tmp_path / "noise.stl", b"\x00\x01 not a surface"),
        write(tmp_path / "what.xyzzy", b"1 2 3"),
        write(tmp_path / "cut.ply", good.read_bytes()[:300]),
    ]
    for path in cases:
        with pytest.raises(InputError, match="remedy") as refusal:
            read_surface(path)
        assert str(path) in str(refusal.value)


def test_unknown_unit(tmp_path):
    with pytest.raises(InputError, match="furlong"):
        read_surface(tmp_path / "a.ply", unit="furlong")
