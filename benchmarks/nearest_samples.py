"""From how many samples a vertex should take its temperature: each left out and guessed.

    python benchmarks/nearest_samples.py SCENES

SCENES holds the scenes bear, bunny, car, cube, cylinder and sphere. Every sample of an object is
left out in turn and guessed from the k that are nearest to it, by inverse distance as
`sample_weights` does. Fields: one that is linear in a direction drawn at random; waves of one and
of three periods over the object's diagonal, along such directions; the last frames of the runs that
are not held out.
`worse` is the root mean square error over that of the field's own best k. Leaves
benchmarks/results/nearest_samples.csv and prints, for each k, the geometric mean and the largest
of `worse`.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from thermo.imaging import NEAREST
from thermo.observe import read_scene

RESULTS = Path(__file__).resolve().parent / "results" / "nearest_samples.csv"
OBJECTS = ("bear", "bunny", "car", "cube", "cylinder", "sphere")
MOST = 16  # samples that are tried
LEAST = 0.01  # K, what a run's last frame must span: the sphere's is the same everywhere


def fields_of(folder: Path) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Names, positions (samples, 3) [m] and values (samples,)."""
    scene = read_scene(folder)
    random = np.random.default_rng(0)
    points = next(iter(scene.runs.values())).recording.points
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    for periods in (0, 1, 3):
        way = random.normal(size=3)
        along = points @ (way / np.linalg.norm(way)) / diagonal
        wave = np.sin(2 * np.pi * periods * along + random.uniform(0, 2 * np.pi))
        yield f"{periods} periods" if periods else "linear", points, wave if periods else along
    for name, run in scene.runs.items():
        last = run.recording.temperature[-1]
        if not run.held_out and np.ptp(last) > LEAST:
            yield f"end of {name}", run.recording.points, last


def errors(points: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Root mean square error for k = 1 .. MOST, (MOST,), in the unit of the values."""
    distance, nearest = KDTree(points).query(points, k=MOST + 1)
    # The nearest of all is the sample itself.
    closeness, known = 1.0 / distance[:, 1:], values[nearest[:, 1:]]
    guessed = np.cumsum(closeness * known, axis=1) / np.cumsum(closeness, axis=1)
    return np.sqrt(np.mean((guessed - values[:, None]) ** 2, axis=0))


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", type=Path)
    arguments = parser.parse_args()
    rows, every = [], []
    for name in OBJECTS:
        for field, points, values in fields_of(arguments.scenes / name):
            found = errors(points, values)
            every.append(found / found.min())
            rows.append([name, field, len(points), *(f"{one:.4f}" for one in every[-1])])
    mean, most = np.exp(np.log(every).mean(axis=0)), np.max(every, axis=0)
    for k in range(MOST):
        chosen = "  <- taken" if k + 1 == NEAREST else ""
        print(f"k = {k + 1:2}: worse by {mean[k] - 1:.1%}, at most {most[k] - 1:.0%}{chosen}")
    print(f"{len(every)} fields of {len(OBJECTS)} objects")
    with RESULTS.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        header = ["object", "field", "samples", *(f"worse, k = {k + 1}" for k in range(MOST))]
        writer.writerows([header, *rows])


if __name__ == "__main__":
    main()
