"""Rendered frames, kept in blocks on the disk, so that a render that was stopped goes on."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

import numpy as np
from jaxtyping import Float

from thermo.observe import write_whole

from ._pixel_map import PixelMap
from ._render import render

_KEY: Final = "render.txt"
_EACH: Final = 32


@final
@dataclass(frozen=True)
class Blocks:
    """Radiometric frames in a folder of their own.

    Arguments:

    - `folder`: that holds the blocks, numbered, each an NPY file (frames, rows, columns) [K].
    - `frames`: how many there are in all. `each`: in a block, but for the last.
    - `size`: rows and columns of a frame [px].
    """

    folder: Path
    frames: int
    each: int
    size: tuple[int, int]

    def starts(self) -> range:
        """The first frame of each block."""
        return range(0, self.frames, self.each)

    def path(self, start: int) -> Path:
        """The file of the block that begins with this frame."""
        return self.folder / f"frames-{start:07d}.npy"

    def load(self, start: int) -> Float[np.ndarray, "frames rows columns"] | None:
        """A block's frames [K], or None where it is not there or is not whole."""
        try:
            values = np.load(self.path(start), allow_pickle=False)
        except (OSError, ValueError, EOFError):
            return None
        wanted = (min(self.each, self.frames - start), *self.size)
        return values if values.shape == wanted and values.dtype == np.float32 else None


def render_blocks(
    folder: Path,
    pixel_map: PixelMap,
    vertex_temperature: Float[np.ndarray, "frames vertices"],
    *,
    on_frames: Callable[[int, int], None] | None = None,
    each: int = _EACH,
) -> Blocks:
    """Render frames [K] into a folder, in single precision; blocks that are there are kept.

    They are kept if the folder was begun for the same view, temperatures and block size, which
    `render.txt` tells by their SHA-256; they are removed if not.

    Arguments: `on_frames(done, total)` is called after each block; what it raises stops the render,
    and loses nothing. `each`: frames a block [1].
    """
    count = len(vertex_temperature)
    blocks = Blocks(folder, count, each, pixel_map.size())
    _begin(blocks, _key(pixel_map, vertex_temperature, each))
    for start in blocks.starts():
        end = min(start + each, count)
        if blocks.load(start) is None:
            part = [
                render(pixel_map, row).astype(np.float32) for row in vertex_temperature[start:end]
            ]
            with write_whole(blocks.path(start)) as temporary:
                np.save(temporary, np.stack(part), allow_pickle=False)
        if on_frames is not None:
            on_frames(end, count)
    return blocks


def frames_of(blocks: Blocks) -> Iterator[Float[np.ndarray, "rows columns"]]:
    """The frames [K] of finished blocks, one block in memory at a time."""
    for start in blocks.starts():
        values = blocks.load(start)
        if values is None:
            raise FileNotFoundError(blocks.path(start))
        yield from values


def discard(blocks: Blocks) -> None:
    """Remove the blocks, and their folder if nothing else lies in it."""
    for path in (*blocks.folder.glob("frames-*.npy"), blocks.folder / _KEY):
        path.unlink(missing_ok=True)
    try:
        blocks.folder.rmdir()
    except OSError:  # something of another hand lies there
        pass


def _begin(blocks: Blocks, key: str) -> None:
    """Make the folder; empty it of blocks of another render."""
    note = blocks.folder / _KEY
    try:
        same = note.read_text("utf-8") == key
    except (OSError, UnicodeDecodeError):
        same = False
    if not same:
        discard(blocks)
        with write_whole(note) as temporary:
            temporary.write_text(key, "utf-8")


def _key(pixel_map: PixelMap, temperature: np.ndarray, each: int) -> str:
    digest = hashlib.sha256(repr((*pixel_map.size(), *temperature.shape, each)).encode())
    for array in (pixel_map.hit, pixel_map.corners, pixel_map.weights, temperature):
        digest.update(np.ascontiguousarray(array).tobytes())
    return f"thermofield-render/1 {digest.hexdigest()}\n"
