from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from thermo.errors import InputError
from thermo.imaging import Camera, Frames, looking_at
from thermo.imaging import _render_blocks as blocks_module
from thermo.imaging._colours import Colours
from thermo.imaging._film import write_film
from thermo.imaging._pixel_map import look
from thermo.imaging._render import render
from thermo.imaging._render_bar import Degrees, colour_bar
from thermo.mesh import Surface

BALL = trimesh.creation.icosphere(subdivisions=1)
SURFACE = Surface(np.asarray(BALL.vertices, float), np.asarray(BALL.faces))
POSE = looking_at(np.array([0.0, 0.0, 4.0]), np.zeros(3), np.array([0.0, 1.0, 0.0]))
MAP = look(Camera(64, 50, [110.0, 110.0], [31.5, 24.5], POSE), SURFACE)
TIME = np.arange(10) * 0.5
VALUES = 300.0 + np.cos(np.arange(10))[:, None] * SURFACE.vertices[:, 0]
COLOURS = Colours(298.0, 302.0)


class Stopped(Exception):
    pass


def test_radiometric_frames_are_frames(tmp_path: Path) -> None:
    write_film([tmp_path / "a.npz"], MAP, TIME, VALUES)
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]
    with np.load(tmp_path / "a.npz", allow_pickle=False) as archive:
        frames = Frames(archive["time"], archive["frames"])
    np.testing.assert_array_equal(frames.values[3], render(MAP, VALUES[3]).astype(np.float32))
    np.testing.assert_array_equal(frames.valid[0], MAP.triangle >= 0)


def test_a_stopped_render_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = ("film.npz", "film.gif")
    (tmp_path / "once").mkdir()
    (tmp_path / "twice").mkdir()
    once = [tmp_path / "once" / name for name in names]
    twice = [tmp_path / "twice" / name for name in names]
    write_film(once, MAP, TIME, VALUES, colours=COLOURS, each=4)

    made: list[float] = []

    def counted(pixel_map, values):
        made.append(float(values[0]))
        return render(pixel_map, values)

    def stop(done: int, total: int) -> None:
        assert total == 10
        if done == 8:
            raise Stopped

    monkeypatch.setattr(blocks_module, "render", counted)
    with pytest.raises(Stopped):
        write_film(twice, MAP, TIME, VALUES, colours=COLOURS, each=4, on_frames=stop)
    assert len(made) == 8 and not any(path.exists() for path in twice)
    assert (tmp_path / "twice" / "film.npz.parts").is_dir()
    made.clear()
    done: list[int] = []
    write_film(
        twice, MAP, TIME, VALUES, colours=COLOURS, each=4, on_frames=lambda a, _: done.append(a)
    )
    assert made == VALUES[8:, 0].tolist() and done == [4, 8, 10]
    for first, second in zip(once, twice, strict=True):
        assert first.read_bytes() == second.read_bytes()
    assert sorted(path.name for path in (tmp_path / "twice").iterdir()) == sorted(names)


@pytest.mark.parametrize("degrees", [None, Degrees.CELSIUS])
def test_films_show_the_colour_bar(tmp_path: Path, degrees: Degrees | None) -> None:
    write_film([tmp_path / "a.gif"], MAP, TIME, VALUES, colours=COLOURS, degrees=degrees)
    bar = 0 if degrees is None else colour_bar(50, COLOURS, degrees).shape[1]
    with Image.open(tmp_path / "a.gif") as image:
        assert image.size == (64 + bar, 50)


def test_an_mp4_is_written(tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    write_film([tmp_path / "a.mp4"], MAP, TIME, VALUES, colours=COLOURS)
    assert (tmp_path / "a.mp4").stat().st_size > 500


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"paths": ["a.avi"]}, "ends? in .npz"),
        ({"paths": []}, "no path"),
        ({"paths": ["a.gif"], "colours": None}, "needs colours"),
        ({"paths": ["a.gif"], "rate": 51.0}, "at most 50"),
        ({"each": 0}, "whole number above 0"),
        ({"time": TIME[:9]}, "10 frames, 9 times"),
        ({"time": TIME[::-1].copy()}, "does not increase"),
        ({"values": VALUES[:, :-1]}, "as was looked at"),
        ({"values": VALUES - 273.15}, "kelvin"),
        ({"values": np.where(VALUES > 300.5, np.nan, VALUES)}, "NaN at frame 0"),
    ],
)
def test_what_is_refused_before_anything_is_written(
    tmp_path: Path, change: dict, message: str
) -> None:
    given = {"paths": ["a.npz"], "time": TIME, "values": VALUES, "colours": COLOURS} | change
    paths = [tmp_path / "new" / name for name in given.pop("paths")]
    time, values = given.pop("time"), given.pop("values")
    with pytest.raises(InputError, match=message):
        write_film(paths, MAP, time, values, **given)
    assert not list(tmp_path.iterdir())


def test_a_camera_that_sees_nothing_is_refused(tmp_path: Path) -> None:
    away = looking_at(np.array([0.0, 0, 4.0]), np.array([0.0, 0, 9.0]), np.array([0.0, 1.0, 0.0]))
    empty = look(Camera(8, 6, [9.0, 9.0], [3.5, 2.5], away), SURFACE)
    with pytest.raises(InputError, match="sees nothing"):
        write_film([tmp_path / "a.npz"], empty, TIME, VALUES)
