"""Samples of an object that is smaller than its surface says are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from thermo.errors import InputError
from thermo.inverse._span_of_samples import check_span
from thermo.mesh import Surface, read_surface
from thermo.observe import Recording


def angle(folder: Path, unit: float) -> Surface:
    """One of 40 x 35 x 30 mm, its corner at the origin, in a unit so many times as large."""
    outline = np.array([[0, 0], [40, 0], [40, 6], [5, 6], [5, 30], [0, 30]])
    vertices = np.array([[x, y, z] for y in (0.0, 35.0) for x, z in outline])
    fan = np.array([[0, n, n + 1] for n in range(1, 5)])
    rims = [[n, (n + 1) % 6, (n + 1) % 6 + 6] for n in range(6)]
    rims += [[n, (n + 1) % 6 + 6, n + 6] for n in range(6)]
    solid = trimesh.Trimesh(1e-3 * unit * vertices, np.vstack([fan, fan[:, ::-1] + 6, rims]))
    solid.fix_normals()
    solid.export(folder / "angle.ply")
    return read_surface(folder / "angle.ply", unit="m")


def recording(points: np.ndarray) -> Recording:
    return Recording(points, [0.0, 1.0], np.full((2, len(points)), 300.0))


@pytest.mark.parametrize("unit", [10.0, 25.4])
def test_those_of_an_object_whose_unit_is_too_large_are_refused(
    unit: float, tmp_path: Path
) -> None:
    surface = angle(tmp_path, 1.0)
    random = np.random.default_rng(0)
    corners = surface.vertices[surface.triangles]
    share = random.dirichlet(np.ones(3), 160)
    area = np.linalg.norm(np.cross(*np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 0)), axis=1)
    picked = random.choice(len(corners), 160, p=area / area.sum())
    points = np.einsum("sc,scx->sx", share, corners[picked])
    check_span(recording(points), surface, "runs.lamp.recording")
    large = angle(tmp_path, unit)
    with pytest.raises(InputError, match="in a corner of the object") as caught:
        check_span(recording(points), large, "runs.lamp.recording")
    assert caught.value.where == "runs.lamp.recording: points"
    assert "unit" in caught.value.remedy and "span 0.06" in str(caught.value.value)
    # Few sensors may be anywhere within what is asked of all; a window that lies on it is well.
    check_span(recording(points[:9]), large, "runs.lamp.recording")
    window = points[points[:, 2] < 1e-6]
    assert len(window) > 20, "the underside lies in the large one's"
    check_span(recording(window), large, "runs.lamp.recording")
