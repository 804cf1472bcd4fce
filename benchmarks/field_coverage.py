"""How often the 95 % bands of a field hold the truth from place to place, on the bracket.

    python benchmarks/field_coverage.py [--draws 4] [--nodes 15000]

The bracket of examples/ was simulated by another program and read with a camera's noise. Each draw
adds as much noise again, with a pattern and quiet frames; the first line is of the recordings as
they are. Each is fitted on control points with the default settings, `thermo.inverse.posterior`
says what is left open, and the faces whose band holds the truth are counted by area: `informed`
where the data tell at least half, of these `edge` within 5 mm of where the two materials meet,
about as far as the fit's control points lie apart, and `away` the rest. The truth of a face, 4 or
1 W/m/K on either side of x = -19 mm, is that of the cell behind it: a side of the wall lies in that
very plane.
`nodes` is about the most of the fit's mesh, `band` the median half-width of a band and `error` the
median error of log(k). Leaves benchmarks/results/field_coverage.csv, to which the same command adds
the draws that it lacks.
"""

from __future__ import annotations

import argparse
import csv
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import thermo
from thermo.inverse import Meshing, posterior
from thermo.mesh import face_areas, face_centres
from thermo.observe import Recording, Scene, read_scene, with_camera_noise

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results" / "field_coverage.csv"
MEET, EDGE = -0.019, 0.005  # m
VALUES = (4.0, 1.0)  # W/m/K
NORMAL = 1.96
COLUMNS = (
    "draw", "nodes", "all", "informed", "edge", "away", "not informed", "band", "error",
    "fit_seconds", "seconds",
)  # fmt: skip


def noisier(scene: Scene, seed: int) -> Scene:
    """The scene with as much noise again on its recordings; as it is for seed 0."""
    if seed == 0:
        return scene
    runs = {}
    for number, (name, run) in enumerate(scene.runs.items()):
        record, quiet = run.recording, run.recording.quiet
        assert quiet is not None, "the recordings of the bracket have quiet frames"
        more = with_camera_noise(
            record, run.initial_temperature, quiet=len(quiet), seed=100 * seed + number
        )
        assert more.quiet is not None, "as many as there were"
        twice = Recording(
            record.points, record.time, more.temperature, record.valid,
            quiet + more.quiet - run.initial_temperature,
        )  # fmt: skip
        runs[name] = replace(run, recording=twice)
    return replace(scene, runs=runs)


def line(scene: Scene, draw: int, meshing: Meshing) -> list[str]:
    """The row of one draw."""
    begun = time.monotonic()
    estimate = thermo.invert(scene, meshing=meshing)
    fitted = time.monotonic()
    left = posterior(scene, estimate, meshing=meshing)
    seconds = time.monotonic() - fitted
    centres, areas = face_centres(left.mesh), face_areas(left.mesh)
    behind = left.mesh.nodes[left.mesh.cells[left.mesh.owners][:, :4]].mean(1)
    truth = np.where(behind[:, 0] < MEET, *VALUES)
    apart = np.abs(np.log(estimate.fields["conductivity"].faces / truth))
    band = NORMAL * left.deviation("conductivity")
    seen = left.informed("conductivity") >= 0.5
    edge = np.abs(centres[:, 0] - MEET) < EDGE
    groups = (np.ones_like(edge), seen, seen & edge, seen & ~edge, ~seen)
    shares = [np.average((apart < band)[mine], weights=areas[mine]) for mine in groups]
    sizes = (*shares, np.median(band), np.median(apart), fitted - begun, seconds)
    return [str(draw), str(meshing.max_nodes), *(f"{size:.3g}" for size in sizes)]


def done() -> list[list[str]]:
    """The rows that were made before."""
    if not RESULTS.exists():
        return []
    with RESULTS.open(newline="") as stream:
        return list(csv.reader(stream))[1:]


def main() -> None:
    """Print the table and write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=4)
    parser.add_argument("--nodes", type=int, default=15_000)
    asked = parser.parse_args()
    scene = read_scene(HERE.parent / "examples" / "bracket")
    print(*COLUMNS)
    lines = done()
    there = {tuple(row[:2]) for row in lines}
    wanted = range(asked.draws + 1)
    for draw in (one for one in wanted if (str(one), str(asked.nodes)) not in there):
        lines.append(line(noisier(scene, draw), draw, Meshing(max_nodes=asked.nodes)))
        print(*lines[-1], flush=True)
        with RESULTS.open("w", newline="") as stream:
            csv.writer(stream, lineterminator="\n").writerows([COLUMNS, *lines])


if __name__ == "__main__":
    main()
