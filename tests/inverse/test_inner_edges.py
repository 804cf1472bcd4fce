"""Cells along edges at which a surface turns inward."""

from __future__ import annotations

import numpy as np
import pytest
from angled import angled
from box_scene import SIZE

from thermo.inverse import Meshing, _predict
from thermo.inverse import _inner_edges as module
from thermo.inverse._inner_edges import at_inner_edges, mesh_to_measure
from thermo.mesh import Fine, Mesh, Sizing, box_mesh
from thermo.observe import Scene


@pytest.mark.parametrize(
    ("skin", "most", "shorter"),
    [
        (0.002, 0, 4.0), (0.004, 0, 2.0), (0.004, 6000, 4.0),
        (0.012, 0, None), (0.012, 700, 2.0), (0.012, 6000, 4.0),
    ],
)  # fmt: skip
def test_edges_there_are_as_short_as_nodes_last(
    skin: float, most: int, shorter: float | None
) -> None:
    # One edge of 20 mm; that it takes more nodes than half of all others needs long cells.
    found = at_inner_edges(angled(), Sizing(skin, skin, skin), 2.0, most)
    assert [one.edge for one in found] == (
        [] if shorter is None else [pytest.approx(skin / shorter)]
    )


def test_lengths_there_fall_faster_so_that_errors_fall_alike() -> None:
    edges = []
    for finer in (2.0, 4.0):
        (fine,) = at_inner_edges(angled(), Sizing(0.002, 0.002, 0.002).divided(finer), finer, 0)
        edges.append(fine.edge)
    assert (edges[0] / edges[1]) ** (4 / 3) == pytest.approx(2.0**2)


def test_a_mesh_is_made_with_them_beside_others(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[Fine, ...]] = []

    def make_mesh(*_: object, fine: tuple[Fine, ...], finer: float) -> Mesh:
        asked.append(fine)
        return box_mesh((0.01, 0.01, 0.01 * finer), (1, 1, 1))

    monkeypatch.setattr(module, "make_mesh", make_mesh)
    own = Fine(np.zeros((1, 3)), 1e-3)
    mesh = mesh_to_measure(scene, angled(), 5e-7, Meshing(), finer=3.0, fine=(own,))
    assert mesh.nodes[:, 2].max() == pytest.approx(0.03)
    ((first, added),) = asked
    assert first is own
    np.testing.assert_allclose(added.points[:, [0, 2]], 0.01, atol=1e-12)


def test_what_is_simulated_is_on_such_a_mesh_and_on_one_half_as_fine(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[float] = []

    def mesh_to_measure(*_: object, finer: float) -> Mesh:
        asked.append(finer)
        return box_mesh(SIZE.tolist(), [round(2 * finer)] * 3)

    monkeypatch.setattr(_predict, "mesh_to_measure", mesh_to_measure)
    found = _predict.simulate(scene, "lamp", values={"conductivity": 2.0})
    assert sorted(asked) == [0.5, 1.0]
    assert np.isfinite(found.temperature).all() and found.cells.max() > 0
