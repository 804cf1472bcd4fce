"""Cameras of the Middlebury data."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cameras import camera_at
from PIL import Image

from thermo.errors import InputError
from thermo.imaging import Axes, View, project, read_cameras, write_middlebury
from thermo.imaging import write_transforms as write_other

DINO = Path(__file__).parents[3] / "shared/data/multiview/middlebury_dinoSparseRing"


def picture(path: Path, size: tuple[int, int] = (64, 48)) -> None:
    Image.new("L", size).save(path)


def test_cameras_are_read_as_they_were_written(tmp_path: Path) -> None:
    views = [View(camera_at((0.5, 0.1, 0.2 * k)), f"{k}.png") for k in (1, 2)]
    for view in views:
        picture(tmp_path / view.file)
    path = tmp_path / "object_par.txt"
    write_middlebury(path, views)
    for one, two in zip(views, read_cameras(path), strict=True):
        assert (two.file, two.camera.name) == (one.file, Path(one.file).stem)
        assert (two.camera.width, two.camera.height) == (64, 48)
        for name in ("focal", "centre", "pose"):
            np.testing.assert_allclose(
                getattr(one.camera, name), getattr(two.camera, name), atol=1e-14
            )


def test_lenses_that_bend_cannot_be_written(tmp_path: Path) -> None:
    bent = View(camera_at((1.0, 0.0, 0.0), bends=(0.1, 0.0, 0.0, 0.0, 0.0)), "a.png")
    with pytest.raises(InputError, match="bends"):
        write_middlebury(tmp_path / "x_par.txt", [bent])
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="cannot be written"):
        write_other(tmp_path / "absent" / "t.json", [bent])


LINE = "a.png 500 0 32 0 500 24 0 0 1  1 0 0 0 1 0 0 0 1  0 0 1"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no Middlebury"),
        (f"2\n{LINE}\n", "1 pictures after the line `2`"),
        ("1\na.png 1 2 3\n", "line 2: this line is no camera"),
        (f"1\n{LINE.replace('500 0 32', '500 1 32')}\n", "upright pixels"),
        (f"1\n{LINE.replace('a.png', 'b.png')}\n", "size of the pictures"),
        (f"1\n{LINE.replace('1 0 0 0 1 0', '1 0 0 0 -1 0')}\n", "mirror"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "x_par.txt"
    path.write_text(text, "utf-8")
    picture(tmp_path / "a.png")
    with pytest.raises(InputError, match=words) as caught:
        read_cameras(path)
    assert "x_par.txt" in str(caught.value)


def test_its_axes_and_unit_are_fixed(tmp_path: Path) -> None:
    path = tmp_path / "x_par.txt"
    path.write_text(f"1\n{LINE}\n", "utf-8")
    picture(tmp_path / "a.png")
    with pytest.raises(InputError, match="`axes` is fixed"):
        read_cameras(path, axes=Axes.OPENGL)
    with pytest.raises(InputError, match="`scale` is fixed"):
        read_cameras(path, scale=0.001)


@pytest.mark.skipif(not DINO.is_dir(), reason=f"the photographs are not at {DINO}")
def test_the_dinosaur_s_box_is_in_view() -> None:
    views = read_cameras(next(DINO.glob("*_par.txt")))
    assert len(views) == 16 and {one.camera.width for one in views} == {640}
    box = np.array([[-0.061897, -0.018874, -0.057845], [0.010897, 0.068227, 0.015495]])
    for view in views:
        pixels, depth = project(view.camera, box.mean(axis=0)[None])
        assert 0.5 < depth[0] < 0.8
        assert np.all(np.abs(pixels[0] - [320, 240]) < [160, 120])
