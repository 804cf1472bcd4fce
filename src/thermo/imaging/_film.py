"""A film of a surface's temperatures, from one camera."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from jaxtyping import Float, UInt8

from thermo.errors import InputError
from thermo.observe import check_kelvin, check_number, check_time

from ._colours import Colours, coloured
from ._pixel_map import PixelMap
from ._render import check_values
from ._render_bar import Degrees, colour_bar
from ._render_blocks import Blocks, discard, frames_of, render_blocks
from ._render_writers import FASTEST_GIF, need_ffmpeg, write_gif, write_mp4, write_radiometric

FILMS: Final = (".npz", ".gif", ".mp4")
"""Endings of the films that can be written."""


def write_film(
    paths: Sequence[Path],
    pixel_map: PixelMap,
    time: Float[np.ndarray, " times"],
    vertex_temperature: Float[np.ndarray, "frames vertices"],
    *,
    colours: Colours | None = None,
    degrees: Degrees | None = Degrees.KELVIN,
    rate: float = 10.0,
    on_frames: Callable[[int, int], None] | None = None,
    each: int = 32,
) -> None:
    """Render frames once and write them as one or several films.

    The radiometric frames are rendered in blocks into a folder beside the first film, its name with
    `.parts` after it. A render that was stopped begins there again: blocks that are whole are not
    rendered anew, and the films come out the same. The folder goes once all films are written.

    Arguments:

    - `paths`: the films. NPZ holds `time` [s] and `frames` [K] (frames, rows, columns), NaN where
      nothing is seen; GIF and MP4 show colours.
    - `pixel_map`: what the camera sees, made by `look`.
    - `time`: of the frames, one each [s], increasing.
    - `vertex_temperature`: (frames, vertices) [K].
    - `colours`: of GIF and MP4. `degrees`: of their colour bar; None leaves it out.
    - `rate`: at which GIF and MP4 are shown, frames a second [Hz].
    - `on_frames(done, total)`: is called after each block. `each`: frames a block [1].

    Raises `InputError`, before anything is rendered, for endings and rates that cannot be written,
    for values that do not fit or are no kelvin, and where the camera sees nothing of the surface.

    Source: paper, appendix A.1, "Thermal Infrared Video Rendering" (checklist F9, F10).
    """
    _check_paths(paths, colours, rate)
    _check_frames(pixel_map, time, vertex_temperature)
    if not isinstance(each, int) or isinstance(each, bool) or each < 1:
        raise InputError(
            "a block holds no such number of frames", where="each", value=each,
            limit="a whole number above 0", remedy="leave it out",
        )  # fmt: skip
    bar = None
    if colours is not None and degrees is not None and _shows(paths):
        bar = colour_bar(pixel_map.size()[0], colours, degrees)
    folder = paths[0].with_name(paths[0].name + ".parts")
    blocks = render_blocks(folder, pixel_map, vertex_temperature, on_frames=on_frames, each=each)
    for path in paths:
        ending = path.suffix.lower()
        if ending == ".npz":
            write_radiometric(path, time, frames_of(blocks))
        elif colours is not None:
            pictures = _pictures(blocks, colours, bar)
            if ending == ".gif":
                write_gif(path, pictures, colours, rate=rate)
            else:
                write_mp4(path, pictures, rate=rate)
    discard(blocks)


def _pictures(
    blocks: Blocks, colours: Colours, bar: np.ndarray | None
) -> Iterator[UInt8[np.ndarray, "rows columns 3"]]:
    for frame in frames_of(blocks):
        picture = coloured(frame, colours)
        yield picture if bar is None else np.concatenate([picture, bar], axis=1)


def _shows(paths: Sequence[Path]) -> bool:
    """Whether any of the films shows colours."""
    return any(path.suffix.lower() != ".npz" for path in paths)


def _check_paths(paths: Sequence[Path], colours: Colours | None, rate: float) -> None:
    endings = [path.suffix.lower() for path in paths]
    wrong = [path for path, ending in zip(paths, endings, strict=True) if ending not in FILMS]
    if wrong or not paths:
        raise InputError(
            "no film is written so", where="paths", value=str(wrong[0]) if wrong else "no path",
            limit=f"names that end in {', '.join(FILMS)}", remedy="give the film such a name",
        )  # fmt: skip
    if not _shows(paths):
        return
    if colours is None:
        raise InputError(
            "a film needs colours", where="colours", value=None,
            limit="`Colours(lowest, highest)` of the temperatures to be shown [K]",
            remedy="give `colours`, or write NPZ alone, which keeps the temperatures",
        )  # fmt: skip
    most = FASTEST_GIF if ".gif" in endings else 240.0
    check_number(rate, where="rate", quantity="frames a second [Hz]", above=0.0, most=most)
    if ".mp4" in endings:
        need_ffmpeg()


def _check_frames(pixel_map: PixelMap, time: np.ndarray, temperature: np.ndarray) -> None:
    check_time(time, where="time", earliest=None, least_frames=1)
    check_values(pixel_map, temperature.shape[1])
    check_kelvin(temperature, where="vertex temperature")
    if np.isnan(temperature).any():
        frame, vertex = np.argwhere(np.isnan(temperature))[0]
        raise InputError(
            "a vertex has no temperature", where="vertex temperature",
            value=f"NaN at frame {frame}, vertex {vertex}", limit="finite kelvin",
            remedy="bring samples to all vertices by `interpolated`",
        )  # fmt: skip
    if len(time) != len(temperature):
        raise InputError(
            "frames and times differ in number", where="time",
            value=f"{len(temperature)} frames, {len(time)} times", limit="one time a frame",
            remedy="give one time a frame",
        )  # fmt: skip
    if len(pixel_map.hit) == 0:
        raise InputError(
            "this camera sees nothing of the surface", where="pixel_map",
            value="no pixel meets it", limit="at least one pixel",
            remedy="check the camera's pose (world to camera, metres) and the surface's unit",
        )  # fmt: skip
