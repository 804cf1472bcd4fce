"""What a recording lacks: dropped and repeated frames, dead pixels, jumps of the shutter."""

from __future__ import annotations

from typing import Final, final

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float, Int

from thermo.errors import InputError

from ._dead_pixels import dead_pixels
from ._frames import Frames
from ._shutter_jumps import shutter_jumps

_GAP: Final = 1.5
"""Median intervals [1] above which at least one frame is missing."""

_SHOWN: Final = 5


@final
class FrameFaults(eqx.Module):
    """What was found in a recording; frames are counted from 0 in the recording as it was read.

    - `count`: its frames; `counts`: whether it holds counts.
    - `gap`: the last frame before each gap; `missing`: frames that are absent there; `interval`:
      how long each gap is [s].
    - `duplicate`: frames that repeat the one before.
    - `dead`: pixels that do not measure.
    - `jump`: the first frame after each jump of the whole image; `height`: how far it went [K], or
      [1] of counts.
    """

    count: int = eqx.field(static=True)
    counts: bool = eqx.field(static=True)
    gap: Int[np.ndarray, " gaps"]
    missing: Int[np.ndarray, " gaps"]
    interval: Float[np.ndarray, " gaps"]
    duplicate: Int[np.ndarray, " duplicates"]
    dead: Bool[np.ndarray, "rows columns"]
    jump: Int[np.ndarray, " jumps"]
    height: Float[np.ndarray, " jumps"]

    def any(self) -> bool:
        """Whether anything was found."""
        return bool(self.gap.size or self.duplicate.size or self.jump.size or self.dead.any())

    def sentences(self) -> tuple[str, ...]:
        """What was found, in plain words; one sentence says so if it is nothing."""
        if not self.any():
            return ("No frame is missing or repeated, no pixel dead, and nothing jumps.",)
        unit = "counts" if self.counts else "K"
        told: list[str] = []
        if self.gap.size:
            places = [
                f"{gap} ({missing}, {interval:.3g} s)"
                for gap, missing, interval in zip(
                    self.gap, self.missing, self.interval, strict=True
                )
            ]
            told.append(
                f"{_number(int(self.missing.sum()), 'frame')} missing, after frame "
                f"{_listed(places)}."
            )
        if self.duplicate.size:
            places = [str(one) for one in self.duplicate]
            told.append(
                f"{_number(len(places), 'frame')} the same as the one before: {_listed(places)}."
            )
        if self.dead.any():
            places = [f"({column}, {row})" for row, column in np.argwhere(self.dead)]
            told.append(
                f"{_number(len(places), 'pixel')} dead, at column and row {_listed(places)}."
            )
        if self.jump.size:
            places = [
                f"{one} ({height:+.3g} {unit})"
                for one, height in zip(self.jump, self.height, strict=True)
            ]
            told.append(
                "The whole image jumps, as by a shutter, at frame "
                f"{_listed(places)}; this is not repaired."
            )
        return tuple(told)


def find_faults(frames: Frames) -> FrameFaults:
    """Look for what a recording lacks.

    - Gaps: intervals longer than 1.5 times the median interval [s].
    - Duplicates: frames equal to the one before bit by bit, in all pixels that are valid. A sensor
      that repeats an image within one step of its numbers cannot be told from them.
    - Dead pixels and jumps of the whole image: see `dead_pixels` and `shutter_jumps`; in a clean
      recording with white noise the chance of any is meant to be below 0.01 each, and
      `benchmarks/frame_faults.py` counts them, and what is found of faults by their size. Rows and
      blocks that are stuck but still noisy are not seen, nor what is stuck in fewer than three
      frames.

    Works frame by frame; values are copied only where there are duplicates.
    """
    step = np.diff(frames.time)
    middle = float(np.median(step)) if step.size else 0.0
    gap = np.flatnonzero(step > _GAP * middle)
    duplicate = _duplicates(frames)
    kept = np.setdiff1d(np.arange(len(frames.time)), duplicate)
    values, valid = frames.values, frames.valid
    if duplicate.size:
        values, valid = values[kept], valid[kept]
    dead = dead_pixels(values, valid)
    jump, height = shutter_jumps(frames.time[kept], values, valid)
    return FrameFaults(
        count=len(frames.time),
        counts=frames.counts,
        gap=gap,
        missing=np.round(step[gap] / middle).astype(int) - 1,
        interval=step[gap],
        duplicate=duplicate,
        dead=dead,
        jump=kept[jump],
        height=height,
    )


def without_faults(frames: Frames, faults: FrameFaults) -> Frames:
    """The frames [K] or [1] without duplicates, dead pixels not valid; jumps stay.

    Raises `InputError` where `faults` are another recording's.
    """
    here = (len(frames.time), *frames.size())
    there = (faults.count, *faults.dead.shape)
    if here != there:
        raise InputError(
            "these faults are another recording's", where="faults",
            value=f"{there[0]} frames of {there[2]} x {there[1]} px",
            limit=f"{here[0]} frames of {here[2]} x {here[1]} px",
            remedy="look for faults in the recording that they are taken out of",
        )  # fmt: skip
    kept = np.setdiff1d(np.arange(faults.count), faults.duplicate)
    values = frames.values[kept] if faults.duplicate.size else frames.values
    return Frames(
        frames.time[kept], values, frames.valid[kept] & ~faults.dead, counts=frames.counts
    )


def _duplicates(frames: Frames) -> Int[np.ndarray, " duplicates"]:
    found = []
    for index in range(1, len(frames.time)):
        use = frames.valid[index]
        same = use.any() and np.array_equal(use, frames.valid[index - 1])
        values, before = frames.values[index], frames.values[index - 1]
        if same and bool(((values == before) | ~use).all()):
            found.append(index)
    return np.array(found, int)


def _number(count: int, noun: str) -> str:
    return f"1 {noun} is" if count == 1 else f"{count} {noun}s are"


def _listed(places: list[str]) -> str:
    shown = ", ".join(places[:_SHOWN])
    return shown if len(places) <= _SHOWN else f"{shown} and {len(places) - _SHOWN} more"
