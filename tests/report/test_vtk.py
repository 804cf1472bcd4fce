from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import meshio
import numpy as np
import pytest

from thermo.report import write_pvd, write_vtu

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
CELLS = np.array([[0, 1, 2, 3], [1, 2, 3, 4]], dtype=np.int32)
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))


def test_linear_mesh_comes_back(tmp_path: Path) -> None:
    path = tmp_path / "new" / "field.vtu"
    temperature = np.linspace(290.0, 300.0, 5)
    gradient = np.arange(6.0).reshape(2, 3)
    write_vtu(
        path,
        CORNERS,
        CELLS,
        {"temperature [K]": temperature},
        {"region": np.array([0, 1]), "gradient [K/m]": gradient},
    )
    found = meshio.read(path)
    np.testing.assert_array_equal(found.points, CORNERS)
    assert [block.type for block in found.cells] == ["tetra"]
    np.testing.assert_array_equal(found.cells[0].data, CELLS)
    np.testing.assert_array_equal(found.point_data["temperature [K]"], temperature)
    np.testing.assert_array_equal(found.cell_data["region"][0], [0, 1])
    np.testing.assert_array_equal(found.cell_data["gradient [K/m]"][0], gradient)
    assert list(path.parent.iterdir()) == [path]


def test_quadratic_cell_keeps_the_order_of_its_edges(tmp_path: Path) -> None:
    nodes = np.vstack([CORNERS[:4], [(CORNERS[a] + CORNERS[b]) / 2 for a, b in EDGES]])
    write_vtu(tmp_path / "q.vtu", nodes, np.arange(10)[None])
    found = meshio.read(tmp_path / "q.vtu")
    assert found.cells[0].type == "tetra10"
    cell = found.points[found.cells[0].data[0]]
    for k, (a, b) in enumerate(EDGES):
        np.testing.assert_allclose(cell[4 + k], (cell[a] + cell[b]) / 2)
    # 24 is VTK_QUADRATIC_TETRA.
    assert 'Name="types"' in (tmp_path / "q.vtu").read_text()


@pytest.mark.parametrize(
    ("cells", "points", "inside", "text"),
    [
        (CELLS[:, :3], {}, {}, "4 or 10"),
        (CELLS, {"T": np.zeros(4)}, {}, "T: .* 5 nodes"),
        (CELLS, {}, {"k": np.zeros(5)}, "k: .* 2 cells"),
    ],
)
def test_what_does_not_fit_is_refused(
    tmp_path: Path, cells: np.ndarray, points: dict, inside: dict, text: str
) -> None:
    with pytest.raises(ValueError, match=text):
        write_vtu(tmp_path / "a.vtu", CORNERS, cells, points, inside)
    assert list(tmp_path.iterdir()) == []


def test_series_lists_its_files_in_time(tmp_path: Path) -> None:
    write_pvd(tmp_path / "run.pvd", np.array([0.0, 0.1]), ["run_0.vtu", "a & b.vtu"])
    root = ElementTree.parse(tmp_path / "run.pvd").getroot()
    sets = root.findall("./Collection/DataSet")
    assert root.attrib["type"] == "Collection"
    assert [s.attrib["file"] for s in sets] == ["run_0.vtu", "a & b.vtu"]
    assert [float(s.attrib["timestep"]) for s in sets] == [0.0, 0.1]


def test_series_of_unequal_length_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="zip"):
        write_pvd(tmp_path / "run.pvd", [0.0, 1.0], ["a.vtu"])
    assert list(tmp_path.iterdir()) == []
