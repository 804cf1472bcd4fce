"""Voxels along lines of sight."""

from __future__ import annotations

import numpy as np

from thermo.reconstruct._voxels import crossed, voxels_in

GRID = voxels_in(np.zeros(3), np.array([4.0, 3.0, 2.0]), 4)


def met(origin: list[float], line: list[float]) -> list[int]:
    """Numbers of the voxels that one line meets, each once."""
    way = np.array([line], float) / np.linalg.norm(line)
    row = crossed(GRID, np.array(origin, float), way)[0]
    return list(dict.fromkeys(row[row >= 0].tolist()))


def number(x: int, y: int, z: int) -> int:
    return (x * 3 + y) * 2 + z


def test_a_line_along_an_axis_meets_its_row_near_ones_first() -> None:
    assert met([-1.0, 1.5, 0.5], [1, 0, 0]) == [number(x, 1, 0) for x in range(4)]
    assert met([9.0, 1.5, 0.5], [-1, 0, 0]) == [number(x, 1, 0) for x in (3, 2, 1, 0)]


def test_from_within_only_what_lies_ahead_is_met() -> None:
    assert met([2.5, 1.5, 0.5], [1, 0, 0]) == [number(2, 1, 0), number(3, 1, 0)]


def test_lines_that_pass_by_or_see_nothing_meet_none() -> None:
    assert met([-1.0, 5.0, 0.5], [1, 0, 0]) == []
    assert met([-1.0, 1.5, 0.5], [-1, 0, 0]) == []
    assert (crossed(GRID, np.zeros(3) - 1, np.full((1, 3), np.nan)) == -1).all()


def test_slanting_lines_stay_on_their_way() -> None:
    random = np.random.default_rng(0)
    lines = random.normal(size=(50, 3))
    lines /= np.linalg.norm(lines, axis=1, keepdims=True)
    origin = np.array([2.0, 1.5, 1.0])
    middles = GRID.middles()
    for line, row in zip(lines, crossed(GRID, origin, lines), strict=True):
        off = middles[row[row >= 0]] - origin
        aside = np.linalg.norm(off - (off @ line)[:, None] * line, axis=1)
        assert (aside < np.sqrt(3) / 2 + 1e-9).all() and (off @ line > -1).all()
        assert len(off) > 0
