from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from thermo.imaging import Camera, looking_at
from thermo.imaging._pixel_map import look
from thermo.imaging._render import render
from thermo.imaging._render_blocks import discard, frames_of, render_blocks
from thermo.mesh import Surface

BALL = trimesh.creation.icosphere(subdivisions=1)
POSE = looking_at(np.array([0.0, 0.0, 4.0]), np.zeros(3), np.array([0.0, 1.0, 0.0]))
MAP = look(
    Camera(20, 16, [40.0, 40.0], [9.5, 7.5], POSE),
    Surface(np.asarray(BALL.vertices, float), np.asarray(BALL.faces)),
)
VALUES = np.random.default_rng(0).uniform(290.0, 310.0, (7, len(BALL.vertices)))


def stamps(folder: Path) -> dict[str, int]:
    return {path.name: path.stat().st_mtime_ns for path in folder.glob("*.npy")}


def test_frames_are_those_of_render(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    blocks = render_blocks(
        tmp_path / "w", MAP, VALUES, each=3, on_frames=lambda a, b: told.append((a, b))
    )
    assert told == [(3, 7), (6, 7), (7, 7)]
    frames = list(frames_of(blocks))
    assert len(frames) == 7
    for frame, row in zip(frames, VALUES, strict=True):
        np.testing.assert_array_equal(frame, render(MAP, row).astype(np.float32))
    discard(blocks)
    assert not (tmp_path / "w").exists()


def test_whole_blocks_are_kept_and_others_made_anew(tmp_path: Path) -> None:
    blocks = render_blocks(tmp_path, MAP, VALUES, each=3)
    before = stamps(tmp_path)
    blocks.path(3).write_bytes(blocks.path(3).read_bytes()[:200])
    render_blocks(tmp_path, MAP, VALUES, each=3)
    after = stamps(tmp_path)
    changed = [name for name in before if before[name] != after[name]]
    assert changed == [blocks.path(3).name] and len(list(frames_of(blocks))) == 7


@pytest.mark.parametrize("change", ["values", "block"])
def test_blocks_of_another_render_are_removed(tmp_path: Path, change: str) -> None:
    old = render_blocks(tmp_path, MAP, VALUES + 1.0, each=2 if change == "block" else 3)
    (tmp_path / "mine.txt").write_text("kept")
    values = VALUES + 1.0 if change == "block" else VALUES
    blocks = render_blocks(tmp_path, MAP, values, each=3)
    for frame, row in zip(frames_of(blocks), values, strict=True):
        np.testing.assert_array_equal(frame, render(MAP, row).astype(np.float32))
    if change == "block":
        assert not old.path(2).exists()
    discard(blocks)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_pickles_are_no_blocks(tmp_path: Path) -> None:
    blocks = render_blocks(tmp_path, MAP, VALUES, each=7)
    with blocks.path(0).open("wb") as stream:
        np.save(stream, np.array([{}], object), allow_pickle=True)
    assert blocks.load(0) is None
