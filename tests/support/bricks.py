"""Meshes of the block that are the same on every machine, which the mesher's are not."""

from __future__ import annotations

import pytest
from box_scene import SIZE

from thermo.inverse import _inner_edges, _task
from thermo.mesh import Mesh, box_mesh


def lay_bricks(monkeypatch: pytest.MonkeyPatch, counts: tuple[int, int, int]) -> None:
    """Let all that simulates the block use bricks, `counts` [1] along its axes, cut in cells."""

    def make(*_: object, finer: float = 1.0, fine: None = None) -> Mesh:
        del fine
        return box_mesh(SIZE.tolist(), [round(finer * count) for count in counts])

    for user in (_task, _inner_edges):
        monkeypatch.setattr(user, "make_mesh", make)
