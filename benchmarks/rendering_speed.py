"""Frames a second of thermal rendering, once the camera has looked at the surface.

    python benchmarks/rendering_speed.py [--repeats 9] [--frames 60]

A ball of 20 480 triangles before a camera of 640 x 480 pixels, of which it covers about a half,
with other temperatures in each frame. `render` makes the radiometric picture in double precision;
`render with colours` also what is shown, red, green and blue of 8 bits. `set-up` is `look`, made
once a camera.
Other programs may use the machine: the median of the repeats is what counts, and the quickest and
slowest repeat are given too. `ratio` is the median over the 30 frames a second that are asked for.
Leaves benchmarks/results/rendering_speed.csv.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh

from thermo.imaging import Camera, Colours, PixelMap, coloured, look, looking_at, render
from thermo.mesh import Surface

RESULTS = Path(__file__).resolve().parent / "results" / "rendering_speed.csv"
COLUMNS = (
    "step", "triangles", "pixels", "pixels hit", "frames", "repeats", "median per second",
    "slowest per second", "quickest per second", "ratio",
)  # fmt: skip
BAR = 30.0


def ball() -> Surface:
    """A ball of 20 480 triangles."""
    made = trimesh.creation.icosphere(subdivisions=5, radius=0.05)
    return Surface(np.asarray(made.vertices, float), np.asarray(made.faces))


def rates(step: Callable[[], object], count: int, repeats: int) -> np.ndarray:
    """How often a second a step is made that makes `count` of something."""
    step()
    found = []
    for _ in range(repeats):
        begin = time.perf_counter()
        step()
        found.append(count / (time.perf_counter() - begin))
    return np.array(found)


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--frames", type=int, default=60)
    arguments = parser.parse_args()
    surface = ball()
    pose = looking_at(np.array([0.0, -0.2, 0.05]), np.zeros(3), np.array([0.0, 0.0, 1.0]))
    camera = Camera(640, 480, [850.0, 850.0], [319.5, 239.5], pose)
    seen: PixelMap = look(camera, surface)
    turn = np.linspace(0.0, 6.0, arguments.frames)[:, None]
    values = 300.0 + 10.0 * np.cos(turn + surface.vertices @ [40.0, 25.0, 60.0])
    colours = Colours(290.0, 310.0)

    def only_render() -> None:
        for row in values:
            render(seen, row)

    def with_colours() -> None:
        for row in values:
            coloured(render(seen, row), colours)

    steps = {
        "render": (only_render, arguments.frames),
        "render with colours": (with_colours, arguments.frames),
        "set-up": (lambda: look(camera, surface), 1),
    }
    rows = []
    for name, (step, count) in steps.items():
        found = rates(step, count, arguments.repeats)
        median, low, high = np.median(found), found.min(), found.max()
        ratio = "" if count == 1 else f"{median / BAR:.3g}"
        rows.append(
            (name, len(surface.triangles), 640 * 480, len(seen.hit), count, arguments.repeats,
             f"{median:.4g}", f"{low:.4g}", f"{high:.4g}", ratio)
        )  # fmt: skip
        print(f"{name}: {median:.4g} a second ({low:.4g} to {high:.4g})", flush=True)
    with RESULTS.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)


if __name__ == "__main__":
    main()
