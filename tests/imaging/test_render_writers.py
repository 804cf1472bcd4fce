from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from thermo.errors import InputError
from thermo.imaging._colours import Colours, coloured
from thermo.imaging._render_writers import (
    write_gif,
    write_mp4,
    write_picture,
    write_radiometric,
)

COLOURS = Colours(290.0, 310.0)
FRAMES = np.linspace(290.0, 310.0, 6 * 31 * 41).reshape(6, 31, 41)
FRAMES[:, :4] = np.nan
PICTURES = [coloured(one, COLOURS) for one in FRAMES]


def test_a_picture_comes_back(tmp_path: Path) -> None:
    write_picture(tmp_path / "a.png", PICTURES[2])
    with Image.open(tmp_path / "a.png") as image:
        np.testing.assert_array_equal(np.asarray(image), PICTURES[2])
    assert len(list(tmp_path.iterdir())) == 1


def test_a_gif_keeps_frames_colours_and_time(tmp_path: Path) -> None:
    write_gif(tmp_path / "a.gif", PICTURES, COLOURS, rate=30.0)
    with Image.open(tmp_path / "a.gif") as image:
        assert getattr(image, "n_frames", 1) == 6
        total = 0.0
        for number, wanted in enumerate(PICTURES):
            image.seek(number)
            total += image.info["duration"]
            shown = np.asarray(image.convert("RGB")).astype(int)
            assert np.abs(shown - wanted).max() <= 8
            assert (shown[:4] == 255).all()
    assert total == pytest.approx(200.0)  # 6 frames at 30 Hz [ms]
    assert len(list(tmp_path.iterdir())) == 1


def test_an_mp4_has_all_frames(tmp_path: Path) -> None:
    reader = pytest.importorskip("imageio_ffmpeg")
    write_mp4(tmp_path / "a.mp4", PICTURES, rate=12.0)
    count, seconds = reader.count_frames_and_secs(str(tmp_path / "a.mp4"))
    assert count == 6 and seconds == pytest.approx(0.5)
    read = [reader.get_ffmpeg_exe(), "-v", "error", "-i", str(tmp_path / "a.mp4"), "-f", "rawvideo"]
    film = subprocess.run([*read, "-pix_fmt", "rgb24", "-"], capture_output=True, check=True).stdout
    frames = np.frombuffer(film, np.uint8).reshape(6, 32, 42, 3)
    for shown, wanted in zip(frames, PICTURES, strict=True):
        assert np.abs(shown[:31, :41].astype(int) - wanted).mean() < 12
    assert len(list(tmp_path.iterdir())) == 1


def test_without_the_extra_the_message_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(InputError, match=r"thermofield\[video\]"):
        write_mp4(tmp_path / "a.mp4", PICTURES, rate=12.0)
    assert not list(tmp_path.iterdir())


def test_temperatures_come_back_and_equal_frames_make_equal_files(tmp_path: Path) -> None:
    time = np.linspace(0.0, 5.0, 6)
    for name in ("a.npz", "b.npz"):
        write_radiometric(tmp_path / name, time, iter(FRAMES))
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    with np.load(tmp_path / "a.npz", allow_pickle=False) as archive:
        np.testing.assert_array_equal(archive["time"], time)
        assert archive["frames"].dtype == np.float32
        np.testing.assert_array_equal(archive["frames"], FRAMES.astype(np.float32))


@pytest.mark.parametrize("count", [5, 7])
def test_frames_and_times_must_fit(tmp_path: Path, count: int) -> None:
    with pytest.raises(InputError, match=f"6 frames, {count} times"):
        write_radiometric(tmp_path / "a.npz", np.arange(float(count)), iter(FRAMES))
    assert not list(tmp_path.iterdir())


def test_nothing_and_impossible_rates_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nothing to write"):
        write_gif(tmp_path / "a.gif", [], COLOURS, rate=10.0)
    with pytest.raises(InputError, match="at most 50"):
        write_gif(tmp_path / "a.gif", PICTURES, COLOURS, rate=60.0)
    with pytest.raises(InputError, match="above 0"):
        write_mp4(tmp_path / "a.mp4", PICTURES, rate=0.0)
    assert not list(tmp_path.iterdir())
