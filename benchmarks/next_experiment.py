"""Whether the run that `thermo.identify.next_runs` picks is a good one, measured by fits.

    python benchmarks/next_experiment.py [--trials 20] [--draws 5]

A block cools down from a known start. Its conductivity, capacity and convection are unknown, its
emissivity is known, and their common factor is known by that alone: roughly. Twenty runs that could
be made are drawn: a lamp of 0.3 to 3 W anywhere on the top or on one of two sides, on for a part of
60 to 180 s, from the temperature of the room or, every other one, from a known one up to 40 K above
it. The cooling run is fitted, `next_runs` ranks the twenty by slopes at what came out, and then
each is made and fitted together with the cooling run, over a few draws of noise (12 sensors, 30
frames, 0.1 K, each sensor off by 0.1 K, 20 quiet frames). All recordings come from another program
(quadratic functions on another mesh, TR-BDF2, benchmarks/hidden); the fits are corrected for their
cells and steps. One that ends with more misfit than the truth, or where slopes promise more, has
not found its minimum, and is counted as `lost`.

The error of a run is the root mean square over unknowns and draws of the error of log(value); a
trial is won where that of the run that was `picked` is below the `median` of the twenty. `weak` is
the same along the direction that was known least, by which `next_runs` ranks. `by_mean` is the
error of the run with the least `NextRun.mean`. `before` is what the cooling run alone leaves,
`foretold` what slopes expect of `weak_picked`. Trials that are in
benchmarks/results/next_experiment.csv are not made again: raise --trials to go on.
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from hidden._bodies import Body, body_of
from hidden._heat import COLD, Lamp, Physics, simulate
from scipy.interpolate import CubicSpline
from skfem import MeshTet

from thermo.identify import next_runs
from thermo.identify._path import settle
from thermo.inverse import (
    LogModel,
    Meshing,
    Sensitivity,
    Stepping,
    _defect,
    _stepping,
    _task,
    log_model,
    sensitivity,
)
from thermo.inverse._case import Case, make_case
from thermo.inverse._defect import with_shared
from thermo.inverse._properties import Properties
from thermo.inverse._stepping import fit_frames
from thermo.mesh import Mesh, box_mesh
from thermo.observe import Recording, Run, Scene, read_scene
from thermo.physics import TimeGrid

RESULTS = Path(__file__).resolve().parent / "results" / "next_experiment.csv"
SIZE = (0.024, 0.016, 0.010)  # m
# With cells twice as long readings near the lamp are off by 50 mK, with these by a few.
CELLS, BRICKS = (15, 10, 7), (5, 4, 3)
UNKNOWN = ("conductivity", "volumetric_heat_capacity", "convection")
DENSITY, EMISSIVITY = 2000.0, 0.85
FIRST = {"conductivity": 4.0, "volumetric_heat_capacity": 2.4e6, "convection": 10.0}
HOT, FRAMES, SAMPLES, QUIET = 335.0, 30, 12, 20
WHITE, PATTERN, MODEL_ERROR = 0.1, 0.1, 0.01
RUNS, RISE, RADIUS = 20, 1.0, 0.005
TOLERANCE, STEPS = 2e-2, 64
COLUMNS = (
    "trial", "draws", "before", "picked", "median", "best", "worst", "better_than", "by_mean",
    "weak_picked", "weak_median", "weak_better_than", "foretold", "lost", "won", "seconds",
)  # fmt: skip


@dataclass(frozen=True)
class Made:
    """A run: its lamp, first temperature [K] and length [s]."""

    lamp: Lamp
    initial: float
    end: float


COOLING = Made(Lamp((0.012, 0.008, 0.02), (0.0, 0.0, -1.0), RADIUS, 1e-6, 60.0, RISE), HOT, 120.0)


def drawn_run(random: np.random.Generator) -> Made:
    """One of the runs that could be made."""
    x, y, z = random.uniform(0.1, 0.9, 3) * SIZE
    places = [((x, y, 0.02), (0.0, 0.0, -1.0)), ((0.03, y, z), (-1.0, 0.0, 0.0)),
              ((x, -0.01, z), (0.0, 1.0, 0.0))]  # fmt: skip
    centre, way = places[random.integers(3)]
    end = random.uniform(60.0, 180.0)
    power = float(np.exp(random.uniform(np.log(0.3), np.log(3.0))))
    lamp = Lamp(centre, way, RADIUS, power, round(end * random.uniform(0.2, 0.9)), RISE)
    hot = random.uniform(0.0, 40.0) if random.random() < 0.5 else 0.0
    return Made(lamp, COLD + hot, end)


def the_body() -> Body:
    """The block as another program has it."""
    axes = (np.linspace(0, size, cells + 1) for size, cells in zip(SIZE, CELLS, strict=True))
    return body_of(MeshTet.init_tensor(*axes), SAMPLES, seed=1)


def read(body: Body, true: Physics, made: Made) -> tuple[np.ndarray, np.ndarray]:
    """Frames [s] and what the samples are at there [K]."""
    frames = np.linspace(0.0, made.end, FRAMES)
    lamp = None if made is COOLING else made.lamp
    at, values = simulate(body, true, lamp, made.initial, np.ceil(made.end) + 1.0)
    found = np.zeros((FRAMES, values.shape[1]))
    ends = [0.0, *([made.lamp.until] if lamp else []), at[-1]]
    for low, high in zip(ends[:-1], ends[1:], strict=True):
        some = (at >= low - 1e-9) & (at <= high + 1e-9)
        there = (frames >= low - 1e-9) & (frames <= high + 1e-9)
        found[there] = CubicSpline(at[some], values[some])(frames[there])
    return frames, found


def write_scene(folder: Path, body: Body, made: dict[str, Made], found: dict) -> Scene:
    """A scene of runs without noise, whose unknowns begin alike in all trials."""
    body.surface.export(folder / "surface.ply")
    runs = {}
    for name, one in made.items():
        frames, values = found[name]
        np.savez(folder / f"{name}.npz", points=body.points, time=frames, temperature=values)
        lamp = one.lamp
        runs[name] = {
            "recording": f"{name}.npz", "initial_temperature": one.initial,
            "ambient_temperature": COLD, "radiation_temperature": COLD,
            "heater": {
                "kind": "spot", "centre": lamp.centre, "direction": lamp.direction,
                "radius": lamp.radius, "power": lamp.power, "until": lamp.until, "rise": lamp.rise,
            },
        }  # fmt: skip
    scene = {
        "format": "thermofield-scene/1", "object": "block", "surface": "surface.ply",
        "material": {
            "density": DENSITY, "heat_capacity": FIRST["volumetric_heat_capacity"] / DENSITY,
            "conductivity": FIRST["conductivity"],
        },
        "surface_exchange": {"convection": FIRST["convection"], "emissivity": EMISSIVITY},
        "unknown": list(UNKNOWN), "runs": runs,
    }  # fmt: skip
    (folder / "scene.json").write_text(json.dumps(scene), "utf-8")
    return read_scene(folder)


def noisy(run: Run, random: np.random.Generator) -> Run:
    """The run as a camera reads it."""
    clean = run.recording
    error = WHITE * random.standard_normal((QUIET + FRAMES, len(clean.points)))
    error += PATTERN * random.standard_normal(len(clean.points))
    quiet = run.initial_temperature + error[:QUIET]
    values = clean.temperature + error[QUIET:]
    return replace(run, recording=Recording(clean.points, clean.time, values, None, quiet))


def alike(mesh: Mesh, body: Properties, run: Run, **asked: float) -> TimeGrid:
    """Steps as they are planned, the longest cut in two until all runs have as many [s]."""
    grid = PLANNED(mesh, body, run, **asked)
    ends = list(np.asarray(grid.frame_time))
    least = STEPS if asked["tolerance"] >= TOLERANCE else 2 * STEPS
    wanted = least * -(-(len(ends) - 1) // least)
    while len(ends) <= wanted:
        longest = int(np.argmax(np.diff(ends)))
        ends.insert(longest + 1, (ends[longest] + ends[longest + 1]) / 2)
    edges = np.array(ends)
    return TimeGrid(edges[:-1], np.diff(edges), np.arange(len(edges), dtype=np.int32), edges)


PLANNED = _stepping.free_grid
# Compiled once: traced anew, a filter along the frames costs more than a fit.
DOUBTED = eqx.filter_jit(with_shared)


def bricks(*_: object, finer: float = 1.0, fine: None = None) -> Mesh:
    """The block in cells that are those of no other program, and do not depend on a mesher."""
    del fine
    return box_mesh(SIZE, [round(finer * count) for count in BRICKS])


def fitted(model: LogModel, start: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, bool]:
    """Logarithms of the unknowns [1], and whether the truth has less misfit than these."""
    found = settle(model, start, model.bounds)
    apart, _ = model(truth)
    return found.unknowns, bool(found.chi2 > apart @ apart or not found.settled())


@dataclass(frozen=True)
class Fits:
    """Fits of the cooling run with one more, corrected where the model stands."""

    model: LogModel
    stepping: Stepping
    truth: np.ndarray

    def of(
        self, pair: Sequence[int], runs: Sequence[Run], start: np.ndarray
    ) -> tuple[np.ndarray, bool]:
        """`fitted` to two runs, their numbers in the model given."""
        (whole,) = self.model.objective.cases
        places = [self.model.objective.sequence.index(number) for number in pair]
        picked: Case = jax.tree.map(lambda leaf: leaf[np.array(places)], whole)
        space = self.model.objective.space
        fresh = [
            make_case(
                run, space, fit_frames(run, self.stepping), model_error=MODEL_ERROR, where=run.name
            )
            for run in runs
        ]
        # The sensors have nothing in common, whatever chance may make of one in many recordings.
        alone = [replace(one, errors=replace(one.errors, common=None)) for one in fresh]
        data, errors = (
            jax.tree.map(lambda *leaves: jnp.stack(leaves), *(getattr(one, part) for one in alone))
            for part in ("data", "errors")
        )
        objective = replace(
            self.model.objective, cases=(replace(picked, data=data, errors=errors),),
            sequence=tuple(range(len(pair))),
        )  # fmt: skip
        return fitted(replace(self.model, objective=DOUBTED(objective)), start, self.truth)


def ranked(at: Sensitivity) -> tuple[list, np.ndarray]:
    """The runs in the order of `next_runs`, and the direction that is known least before [1]."""

    def only(names: Sequence[str]) -> Sensitivity:
        parts = {
            part: {name: getattr(at, part)[name] for name in names}
            for part in ("slopes", "noise", "staying")
        }
        return replace(at, **parts)

    now = only(["cooling"])
    found = next_runs(
        now, {name: only([name]) for name in at.slopes if name != "cooling"},
        model_error=MODEL_ERROR,
    )  # fmt: skip
    rows = now.slopes["cooling"].reshape(-1, len(UNKNOWN))
    return found, np.linalg.eigh(rows.T @ rows)[1][:, 0]


def trial(number: int, draws: int, body: Body) -> list[object]:
    """The row of one trial."""
    begun, random = time.monotonic(), np.random.default_rng([2026, number])
    true = {
        "conductivity": np.exp(random.uniform(np.log(1.5), np.log(8.0))),
        "volumetric_heat_capacity": random.uniform(1.6e6, 3.4e6),
        "convection": random.uniform(6.0, 16.0),
    }
    capacity = true["volumetric_heat_capacity"] / DENSITY
    physics = Physics(DENSITY, capacity, true["conductivity"], true["convection"], EMISSIVITY)
    made = {"cooling": COOLING} | {f"run{n:02d}": drawn_run(random) for n in range(RUNS)}
    found = {name: read(body, physics, one) for name, one in made.items()}
    with tempfile.TemporaryDirectory() as folder:
        clean = write_scene(Path(folder), body, made, found)
        scene = replace(clean, runs={n: noisy(run, random) for n, run in clean.runs.items()})
        stepping = Stepping(tolerance=TOLERANCE, rtol=1e-7)
        asked = {"unknown": UNKNOWN, "stepping": stepping, "meshing": Meshing()}
        first = log_model(scene, runs=("cooling",), initial=FIRST, model_error=MODEL_ERROR, **asked)
        truth = np.log([true[name] for name in UNKNOWN])
        best, away = fitted(first, first.first, truth)
        there = dict(zip(UNKNOWN, np.exp(best).tolist(), strict=True))
        print(f"trial {number}: {time.monotonic() - begun:.0f} s, first fit", file=sys.stderr)
        order, weak = ranked(sensitivity(scene, runs=tuple(made), initial=there, **asked))
        print(f"trial {number}: {time.monotonic() - begun:.0f} s, slopes", file=sys.stderr)
        model = log_model(scene, runs=tuple(made), initial=there, model_error=MODEL_ERROR, **asked)
    print(f"trial {number}: {time.monotonic() - begun:.0f} s, corrections", file=sys.stderr)
    fits, names = Fits(model, stepping, truth), list(model.runs)
    errors, lost = {}, int(away)
    for name in (one.name for one in order):
        left, start = [], best
        for _ in range(draws):
            pair = [noisy(clean.runs[one], random) for one in ("cooling", name)]
            start, away = fits.of([names.index("cooling"), names.index(name)], pair, start)
            left.append(start - truth)
            lost += away
        errors[name] = np.array(left)
    whole = _row(number, order, weak, errors, best - truth)
    return [*whole[:-1], lost, whole[-1], f"{time.monotonic() - begun:.0f}"]


def _row(
    number: int, order: list, weak: np.ndarray, errors: dict, before: np.ndarray
) -> list[object]:
    whole = {name: float(np.sqrt(np.mean(one**2))) for name, one in errors.items()}
    along = {name: float(np.sqrt(np.mean((one @ weak) ** 2))) for name, one in errors.items()}
    picked, mean = order[0].name, min(order, key=lambda one: one.mean).name
    sizes, weaks = np.array(list(whole.values())), np.array(list(along.values()))
    numbers = (
        np.sqrt(np.mean(before**2)), whole[picked], np.median(sizes), sizes.min(), sizes.max(),
        np.mean(sizes > whole[picked]), whole[mean], along[picked], np.median(weaks),
        np.mean(weaks > along[picked]), order[0].weakest,
    )  # fmt: skip
    won = "yes" if whole[picked] < np.median(sizes) else "no"
    draws = len(errors[picked])
    return [number, draws, *(f"{one:.4g}" for one in numbers), won]


def main() -> None:
    """Print the table and write it, a line as soon as it is known."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--draws", type=int, default=5)
    asked = parser.parse_args()
    for user in (_stepping, _defect):
        user.free_grid = alike
    _task.make_mesh = bricks
    lines: list[list[object]] = []
    if RESULTS.exists():
        lines = list(csv.reader(RESULTS.open(newline="")))[1:]
    done, body = {int(str(line[0])) for line in lines}, the_body()
    print(*COLUMNS)
    for number in range(asked.trials):
        if number in done:
            continue
        lines.append(trial(number, asked.draws, body))
        print(*lines[-1], flush=True)
        with RESULTS.open("w", newline="") as stream:
            csv.writer(stream, lineterminator="\n").writerows([COLUMNS, *lines])
    won = sum(line[COLUMNS.index("won")] == "yes" for line in lines)
    print(f"better than the median in {won} of {len(lines)} trials")


if __name__ == "__main__":
    main()
