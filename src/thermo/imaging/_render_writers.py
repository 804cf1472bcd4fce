"""Pictures and films as files: PNG, GIF, MP4 and radiometric NPZ."""

from __future__ import annotations

import itertools
import subprocess
import zipfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image

from thermo.errors import InputError
from thermo.observe import check_number, write_whole

from ._colours import Colours

FASTEST_GIF: Final = 50.0
"""Most frames a second [Hz] of a GIF, whose time goes in hundredths and whose viewers need two."""

_GREYS: Final = 40


def write_picture(path: Path, picture: UInt8[np.ndarray, "rows columns 3"]) -> None:
    """Write a coloured picture, red, green and blue of 8 bits [1], as PNG, whole or not at all.

    Raises `InputError` where the file cannot be written.
    """
    with write_whole(path) as temporary:
        Image.fromarray(picture).save(temporary, format="PNG")


def write_gif(
    path: Path,
    pictures: Iterable[UInt8[np.ndarray, "rows columns 3"]],
    colours: Colours,
    *,
    rate: float,
) -> None:
    """Write coloured pictures as an endless GIF, whole or not at all.

    All frames share one palette of 256 colours: those of `colours`, its background, and greys for
    what is written beside them.

    Arguments: `rate`, frames a second [Hz], at most 50. Frames that last no whole hundredth of a
    second are long and short in turn.

    Raises `InputError` for another rate, no pictures, and where the file cannot be written.
    """
    check_number(rate, where="rate", quantity="frames a second [Hz]", above=0.0, most=FASTEST_GIF)
    palette = Image.new("P", (1, 1))
    places = np.linspace(0, len(colours.table) - 1, 255 - _GREYS).round().astype(int)
    greys = np.linspace(0, 255, _GREYS).round().astype(np.uint8)[:, None].repeat(3, axis=1)
    every = np.concatenate([colours.background[None], colours.table[places], greys])
    palette.putpalette(every.ravel().tolist())
    frames = [
        Image.fromarray(one).quantize(palette=palette, dither=Image.Dither.NONE)
        for one in _some(pictures)
    ]
    ends = np.round(np.arange(len(frames) + 1) * (100.0 / rate)).astype(int)
    durations = (10 * np.diff(ends)).tolist()
    with write_whole(path) as temporary:
        frames[0].save(
            temporary, format="GIF", save_all=True, append_images=frames[1:], duration=durations,
            loop=0, optimize=False, disposal=1,
        )  # fmt: skip


def write_mp4(
    path: Path, pictures: Iterable[UInt8[np.ndarray, "rows columns 3"]], *, rate: float
) -> None:
    """Write coloured pictures as MP4 (H.264), whole or not at all.

    Pictures of odd height or width get their last row or column twice, which the format wants.

    Arguments: `rate`, frames a second [Hz].

    Raises `InputError` for a rate that is not above 0, no pictures, where the extra `video` is not
    installed, and where the file cannot be written.
    """
    check_number(rate, where="rate", quantity="frames a second [Hz]", above=0.0, most=240.0)
    ffmpeg = need_ffmpeg().get_ffmpeg_exe()
    rest = _some(pictures)
    first = next(rest)
    rows, columns = (len(first) + 1) // 2 * 2, (first.shape[1] + 1) // 2 * 2
    with write_whole(path) as temporary:
        words = [
            ffmpeg, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
            "-s", f"{columns}x{rows}", "-r", f"{rate:g}", "-i", "-", "-an", "-codec:v", "libx264",
            "-crf", "20", "-pix_fmt", "yuv420p", str(temporary),
        ]  # fmt: skip
        # Not by the library's own writer, which forks: with JAX's threads that may never return.
        with subprocess.Popen(
            words, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            process_group=0,
        ) as process:  # fmt: skip
            assert process.stdin is not None
            for one in itertools.chain([first], rest):
                more = ((0, rows - len(one)), (0, columns - one.shape[1]), (0, 0))
                process.stdin.write(np.pad(one, more, mode="edge").tobytes())
            process.stdin.close()
        if process.returncode != 0:
            raise OSError(f"ffmpeg ended with {process.returncode}")


def write_radiometric(
    path: Path,
    time: Float[np.ndarray, " frames"],
    frames: Iterable[Float[np.ndarray, "rows columns"]],
) -> None:
    """Write temperatures as NPZ, whole or not at all: `time` [s] and `frames` [K].

    `frames` is (frames, rows, columns) in single precision, which holds 0.03 mK at room
    temperature; NaN where a pixel sees nothing. The frames pass one by one, so that a film need not
    fit into memory, and equal frames make equal files.

    Raises `InputError` where there are fewer or more frames than times, and where the file cannot
    be written.
    """
    rest = _some(frames)
    first = next(rest)
    shape = (len(time), *first.shape)
    with write_whole(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        _entry(archive, "time", time.shape, [time.astype("<f8")])
        values = (one.astype("<f4") for one in itertools.chain([first], rest))
        written = _entry(archive, "frames", shape, values, kind="<f4")
        if written != len(time):
            raise InputError(
                "frames and times differ in number", where=str(path),
                value=f"{written} frames, {len(time)} times", limit="one time a frame",
                remedy="give one time a frame",
            )  # fmt: skip


def need_ffmpeg() -> Any:
    """The module that films are made with; `InputError` where the extra is not installed."""
    try:
        import imageio_ffmpeg

        imageio_ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError) as error:
        raise InputError(
            "MP4 films need a library that is not here", where="imageio-ffmpeg",
            value=f"{type(error).__name__}: {str(error)[:100]}", limit="the extra `video`",
            remedy="pip install 'thermofield[video]', or write a GIF or NPZ",
        ) from error  # fmt: skip
    return imageio_ffmpeg


def _entry(
    archive: zipfile.ZipFile,
    name: str,
    shape: tuple[int, ...],
    parts: Iterable[np.ndarray],
    *,
    kind: str = "<f8",
) -> int:
    """Write one array part by part, and return how many parts there were."""
    # Without a time of day of its own, equal arrays make equal files.
    about = zipfile.ZipInfo(f"{name}.npy")
    about.compress_type = zipfile.ZIP_DEFLATED
    written = 0
    with archive.open(about, "w", force_zip64=True) as stream:
        header = {"descr": kind, "fortran_order": False, "shape": shape}
        np.lib.format.write_array_header_1_0(stream, header)
        for part in parts:
            stream.write(np.ascontiguousarray(part).tobytes())
            written += 1
    return written


def _some(items: Iterable[np.ndarray]) -> Iterator[np.ndarray]:
    rest = iter(items)
    first = next(rest, None)
    if first is None:
        raise InputError(
            "there is nothing to write", where="frames", value="no frames",
            limit="at least one frame", remedy="give frames",
        )  # fmt: skip
    return itertools.chain([first], rest)
