"""Meshes of a box that are the same on every machine, which the mesher's are not."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from box_scene import SIZE

from thermo.inverse import _inner_edges, _task
from thermo.mesh import Mesh, box_mesh

BRICKS = (5, 4, 3)
"""Along the axes of the block, where a test does not ask for others [1]."""


def lay_bricks(
    monkeypatch: pytest.MonkeyPatch,
    counts: tuple[int, int, int] = BRICKS,
    low: Sequence[float] = (0.0, 0.0, 0.0),
    size: Sequence[float] = tuple(SIZE.tolist()),
) -> None:
    """Let all that simulates a box use bricks, `counts` [1] along its axes, cut in cells.

    `low`: its lowest corner [m]; `size`: its edges [m]; those of the block where none are given.
    """

    def make(*_: object, finer: float = 1.0, fine: None = None) -> Mesh:
        del fine
        return box_mesh(size, [round(finer * count) for count in counts], origin=low)

    for user in (_task, _inner_edges):
        monkeypatch.setattr(user, "make_mesh", make)
