"""How often `find_faults` gives an alarm where nothing is wrong, and finds what is.

    python benchmarks/frame_faults.py [--clean 70] [--faulty 40]

Recordings of 40 frames, a tenth of a second apart by a clock that is off by 3 %, of 24 x 32 pixels:
an object that warms or cools in the middle of the picture, a hump or a block with sharp edges, with
white noise of 0.05 K, as it is or in numbers of 0.05 K.

- Clean ones: each row of the table is a course (the change in the end, its time constant over the
  length of the recording), and says in how many recordings each kind of fault was told of.
- Faulty ones: an even picture, or the hump that warms by 5 K, with one fault at a random place.
  `found` counts the recordings in which it was told of, at its place, of its size (frames missing;
  height of the jump to a quarter of it) and nothing else of its kind; the other columns count what
  else was told of. Sizes in `noise` are those of a pixel's noise in a frame.

Leaves benchmarks/results/frame_faults.csv and prints it; takes a minute or two.
"""

from __future__ import annotations

import argparse
import csv
import itertools
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from thermo.imaging import FrameFaults, Frames, find_faults

RESULTS = Path(__file__).resolve().parent / "results" / "frame_faults.csv"
KINDS = ("gap", "duplicate", "dead", "jump")
HEADER = ("recordings of", "size", "number", "found", *(f"alarms: {kind}" for kind in KINDS))
ROWS, COLUMNS, FRAMES = 24, 32, 40
NOISE, EVERY, CLOCK = 0.05, 0.1, 0.03  # K; s; of EVERY
COURSES = (
    (0.0, 1.0),
    *((end, pace) for end in (0.5, 5.0, -5.0, 50.0) for pace in (0.05, 0.5, 5.0)),
)
SHAPES = (("hump", 0.0), ("block", 0.0), ("hump", NOISE))
SCENES = (("even picture", (0.0, 1.0)), ("hump, +5 K", (5.0, 0.5)))

Fault = Callable[[Frames, np.random.Generator], tuple[Frames, Callable[[FrameFaults], bool]]]


def clean(
    random: np.random.Generator, end: float, pace: float, *, block: bool = False, step: float = 0.0
) -> Frames:
    """An object that goes to `end` [K], `pace` its time constant over the whole time."""
    row, column = np.mgrid[:ROWS, :COLUMNS]
    hump = np.exp(-((row - ROWS / 2) ** 2 + (column - COLUMNS / 2) ** 2) / 72)
    edges = (np.abs(row - ROWS / 2) < 6) & (np.abs(column - COLUMNS / 2) < 8)
    time = EVERY * (np.arange(FRAMES) + CLOCK * random.standard_normal(FRAMES))
    gone = (time - time[0]) / (time[-1] - time[0]) / pace
    course = end * (1 - np.exp(-gone)) / (1 - np.exp(-1 / pace))
    values = 320.0 + course[:, None, None] * (edges if block else hump)
    values += NOISE * random.standard_normal(values.shape)
    return Frames(time, step * np.round(values / step) if step else values)


def told(faults: FrameFaults) -> list[int]:
    """Whether each kind was told of, 0 or 1."""
    return [int(getattr(faults, kind).any() if kind == "dead" else getattr(faults, kind).size > 0)
            for kind in KINDS]  # fmt: skip


def clean_rows(number: int, seed: int) -> Iterator[list[object]]:
    """A row a course: alarms among `number` recordings."""
    for place, ((end, pace), (shape, step)) in enumerate(itertools.product(COURSES, SHAPES)):
        random = np.random.default_rng([seed, place])
        alarms = np.zeros(len(KINDS), int)
        for _ in range(number):
            frames = clean(random, end, pace, block=shape == "block", step=step)
            alarms += told(find_faults(frames))
        name = f"clean {shape}" + (", numbers of 0.05 K" if step else "")
        yield [name, f"{end:+g} K, {pace:g}", number, "", *alarms.tolist()]


def changed(frames: Frames, values: np.ndarray) -> Frames:
    """The same frames with other values [K]."""
    return Frames(frames.time, values)


def dropped(count: int) -> Fault:
    """Frames that are missing."""

    def apply(frames: Frames, random: np.random.Generator) -> tuple[Frames, Callable]:
        after = int(random.integers(2, FRAMES - count - 3))
        kept = np.r_[0 : after + 1, after + 1 + count : FRAMES]
        made = Frames(frames.time[kept], frames.values[kept])
        return made, lambda f: f.gap.tolist() == [after] and f.missing.tolist() == [count]

    return apply


def late(share: float) -> Fault:
    """A frame that comes late by a share of the time between two, and all after it."""

    def apply(frames: Frames, random: np.random.Generator) -> tuple[Frames, Callable]:
        after = int(random.integers(2, FRAMES - 3))
        time = frames.time + share * EVERY * (np.arange(FRAMES) > after)
        return Frames(time, frames.values), lambda f: f.gap.tolist() == [after]

    return apply


def repeated(count: int) -> Fault:
    """Frames that repeat the one before."""

    def apply(frames: Frames, random: np.random.Generator) -> tuple[Frames, Callable]:
        first = int(random.integers(3, FRAMES - count - 2))
        values = frames.values.copy()
        values[first : first + count] = values[first - 1]
        wanted = list(range(first, first + count))
        return changed(frames, values), lambda f: f.duplicate.tolist() == wanted

    return apply


def dead(kind: str, size: float) -> Fault:
    """A pixel that is stuck, off by `size` noises, or flickers with as many."""

    def apply(frames: Frames, random: np.random.Generator) -> tuple[Frames, Callable]:
        place = int(random.integers(ROWS)), int(random.integers(COLUMNS))
        values = frames.values.copy()
        pixel = values[:, *place]
        if kind == "stuck":
            pixel[:] = pixel[0]
        elif kind == "off":
            pixel += size * NOISE * random.choice([-1.0, 1.0])
        else:
            pixel += size * NOISE * random.standard_normal(FRAMES)
        return changed(frames, values), lambda f: np.argwhere(f.dead).tolist() == [list(place)]

    return apply


def jump(size: float) -> Fault:
    """A jump of the whole picture by `size` noises."""

    def apply(frames: Frames, random: np.random.Generator) -> tuple[Frames, Callable]:
        first = int(random.integers(3, FRAMES - 3))
        height = size * NOISE * random.choice([-1.0, 1.0])
        values = frames.values.copy()
        values[first:] += np.float32(height)
        return changed(
            frames, values
        ), lambda f: f.jump.tolist() == [first] and abs(f.height[0] / height - 1) < 0.25

    return apply


FAULTS: tuple[tuple[str, str, str, Fault], ...] = (
    *(("gap", "a frame and all after it late", f"{one:g} intervals", late(one))
      for one in (0.3, 0.7, 1.0)),
    *(("gap", "dropped frames", f"{one} frames", dropped(one)) for one in (1, 3, 10)),
    *(("duplicate", "repeated frames", f"{one} frames", repeated(one)) for one in (1, 3, 10)),
    ("dead", "a stuck pixel", "", dead("stuck", 0.0)),
    *(("dead", "a pixel that is off", f"{one:g} noise", dead("off", one))
      for one in (0.5, 1.0, 2.0, 4.0, 8.0)),
    *(("dead", "a pixel that flickers", f"{one:g} noise", dead("flickers", one))
      for one in (1.0, 2.0, 4.0, 8.0)),
    *(("jump", "a jump of the picture", f"{one:g} noise", jump(one))
      for one in (0.1, 0.25, 0.5, 1.0, 4.0)),
)  # fmt: skip


def faulty_rows(number: int, seed: int) -> Iterator[list[object]]:
    """A row a fault and scene: in how many of `number` recordings it was found, and what else."""
    for (scene, course), (kind, name, size, fault) in itertools.product(SCENES, FAULTS):
        random = np.random.default_rng(seed)
        found, alarms = 0, np.zeros(len(KINDS), int)
        for _ in range(number):
            frames, right = fault(clean(random, *course), random)
            faults = find_faults(frames)
            found += bool(right(faults))
            alarms += told(faults)
        alarms[KINDS.index(kind)] = 0
        yield [f"{scene}: {name}", size, number, found, *alarms.tolist()]


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clean", type=int, default=70, help="recordings of each course")
    parser.add_argument("--faulty", type=int, default=40, help="recordings with each fault")
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    rows: list[list[object]] = []
    for row in clean_rows(asked.clean, asked.seed):
        rows.append(row)
        print(*row, sep=", ", flush=True)
    every = sum(int(str(row[2])) for row in rows)
    alarms = np.sum([row[4:] for row in rows], axis=0)
    rows.append(["all clean ones", "", every, "", *alarms.tolist()])
    print(*rows[-1], sep=", ", flush=True)
    for row in faulty_rows(asked.faulty, asked.seed):
        rows.append(row)
        print(*row, sep=", ", flush=True)
    with RESULTS.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerows([HEADER, *rows])


if __name__ == "__main__":
    main()
