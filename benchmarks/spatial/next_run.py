"""Whether the run that is proposed next tells more than one made at random, by fitting both.

    python benchmarks/spatial/next_run.py [--trials 10] [--runs 20] [--table FILE]

A trial is a plate of random conductivity, capacity and convection, of which one run has been made
and fitted from a guess that is off by 30 %. Then 20 more runs are drawn at random from those that
could be made: where the lamp shines, its power and how long, or a hot start without it.
`next_runs` orders them where the fit stands. Each one is then made (by `truth.py`, with a camera's
noise) and fitted together with the first, over some draws of the noise. `chosen` is the root mean
square error of the fits along the direction that is known least before, with the run that was
proposed first, `median` and `best` that over all twenty; `place` is 1 for the best of them.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import skfem
import trimesh
from scipy.optimize import least_squares
from truth import Body, run

from thermo.identify import next_runs, spectrum
from thermo.inverse import LogModel, Meshing, Prior, Sensitivity, Stepping, log_model, sensitivity
from thermo.observe import Heater, Recording, Run, Scene, StatedMaterial

SIZE = np.array([0.030, 0.020, 0.006])
UNKNOWN = ("conductivity", "volumetric_heat_capacity", "convection")
DENSITY, EMISSIVITY, ROOM = 1200.0, 0.8, 295.15
WHITE, PATTERN, QUIET, SAMPLES, STEP, END = 0.05, 0.03, 25, 30, 1.0, 60.0
DRAWS, GUESS, SPREAD, RADIUS = 6, 0.3, 1.0, 0.005
HEADER = ("trial", "chosen", "median", "best", "place", "better")


@dataclass(frozen=True)
class Plan:
    """A run that could be made: its first temperature [K], its lamp unless `power` [W] is 0."""

    name: str
    start: float
    place: tuple[float, float]
    power: float
    until: float


def drawn_plan(name: str, random: np.random.Generator) -> Plan:
    """Any run that the bench allows."""
    x, y = random.uniform(0.1, 0.9, 2) * SIZE[:2]
    if random.random() < 0.25:
        return Plan(name, random.uniform(300, 345), (x, y), 0.0, 0.0)
    return Plan(name, ROOM, (x, y), random.uniform(0.2, 2.0), random.uniform(5, 55))


class Bench:
    """A plate of given values [SI], and what is measured on it."""

    def __init__(self, values: dict[str, float], folder: Path, random: np.random.Generator) -> None:
        axes = [np.linspace(0, size, n) for size, n in zip(SIZE, (13, 9, 5), strict=True)]
        conductivity, capacity, convection = (values[name] for name in UNKNOWN)
        self.body = Body(
            skfem.MeshTet.init_tensor(*axes), lambda x: np.full(x.shape[1:], conductivity),
            capacity, convection, EMISSIVITY,
        )  # fmt: skip
        self.folder, self.random = folder, random
        surface = trimesh.creation.box(extents=SIZE)
        surface.apply_translation(SIZE / 2)
        surface = surface.subdivide()
        surface.export(folder / "surface.ply")
        seed = int(random.integers(2**31))
        points, _ = trimesh.sample.sample_surface(surface, SAMPLES, seed=seed)
        self.points = np.asarray(points)
        inside = self.points * (1 - 1e-6) + SIZE / 2 * 1e-6
        self.probe = self.body.basis.probes(inside.T)

    def make(self, plan: Plan) -> Run:
        """Make a run, with noise."""
        heater, heat = None, np.zeros(self.body.mass.shape[0])
        if plan.power > 0:
            centre, down = np.array([*plan.place, 0.03]), np.array([0.0, 0.0, -1.0])
            heater = Heater(centre, down, RADIUS, plan.power, round(plan.until))
            heat = plan.power * self.body.lamp(centre, down, RADIUS)
        time, nodal = run(self.body, plan.start, ROOM, heat, round(plan.until), END, STEP / 4)
        clean = nodal[::4] @ self.probe.T
        pattern = PATTERN * self.random.standard_normal(SAMPLES)
        noise, quiet = (
            WHITE * self.random.standard_normal((count, SAMPLES)) + pattern
            for count in (len(clean), QUIET)
        )
        record = Recording(self.points, time[::4], clean + noise, quiet=plan.start + quiet)
        return Run(plan.name, record, plan.start, ROOM, ROOM, heater=heater)

    def scene(self, *runs: Run) -> Scene:
        """What has been recorded, with nothing of the truth."""
        material = StatedMaterial("made up", DENSITY, 1500.0, None)
        by_name = {one.name: one for one in runs}
        return Scene(
            self.folder, "plate", self.folder / "surface.ply", "m", material, 10.0, EMISSIVITY,
            UNKNOWN, {}, by_name,
        )  # fmt: skip


def fitted(model: LogModel, error: np.ndarray | None = None) -> np.ndarray:
    """Logarithms of the values [1] that fit best, with another draw of the noise."""
    more = 0.0 if error is None else error
    low, high = model.bounds.T
    found = least_squares(
        lambda logs: model(logs)[0] + more, np.clip(model.first, low + 1e-6, high - 1e-6),
        jac=lambda logs: model(logs)[1], bounds=(low, high), x_scale="jac", xtol=1e-6,
    )  # fmt: skip
    return np.asarray(found.x)


def weakest(at: Sensitivity, prior: dict[str, float]) -> np.ndarray:
    """The direction of log(phi) that is known least [1], as `next_runs` takes it."""
    before = spectrum(at, prior=prior)
    _, ways = np.linalg.eigh(before.covariance() / np.outer(before.prior, before.prior))
    way = before.prior * ways[:, -1]
    return way / np.linalg.norm(way)


def trial(number: int, count: int, folder: Path) -> list:
    """One plate: errors [1] along the weakest direction with each of the runs."""
    random = np.random.default_rng(number)
    ends = {"conductivity": (0.2, 3.0), "volumetric_heat_capacity": (1e6, 3e6),
            "convection": (5.0, 30.0)}  # fmt: skip
    true = {name: float(np.exp(random.uniform(*np.log(ends[name])))) for name in UNKNOWN}
    bench = Bench(true, folder, random)
    guess = {name: true[name] * float(np.exp(GUESS * random.standard_normal())) for name in UNKNOWN}
    meshing = Meshing(max_nodes=4000, corrected=False, cache=folder / "meshes")
    asked = {"unknown": UNKNOWN, "stepping": Stepping(tolerance=0.02), "meshing": meshing}
    prior = dict.fromkeys(UNKNOWN, SPREAD)

    first = bench.make(drawn_plan("first", random))
    begun = log_model(bench.scene(first), prior=Prior(spread=prior), initial=guess, **asked)
    stands = dict(zip(UNKNOWN, np.exp(fitted(begun)).tolist(), strict=True))

    made = [bench.make(drawn_plan(f"run{n}", random)) for n in range(count)]
    now = sensitivity(bench.scene(first), initial=stands, **asked)
    candidates = {
        one.name: sensitivity(bench.scene(one), initial=stands, **asked) for one in made
    }  # fmt: skip
    way = weakest(now, prior)
    chosen = next_runs(now, candidates, prior=prior)[0].name

    errors = {}
    for one in made:
        both = bench.scene(first, replace(one, name="more"))
        model = log_model(both, prior=Prior(spread=prior), initial=stands, **asked)
        size = model(model.first)[0].shape
        noise = [None, *(random.standard_normal(size) for _ in range(DRAWS - 1))]
        off = [way @ (fitted(model, error) - np.log([true[n] for n in UNKNOWN])) for error in noise]
        errors[one.name] = float(np.sqrt(np.mean(np.square(off))))
    middle = float(np.median(list(errors.values())))
    place = sorted(errors, key=errors.__getitem__).index(chosen) + 1
    mine, best = errors[chosen], min(errors.values())
    return [number, f"{mine:.4g}", f"{middle:.4g}", f"{best:.4g}", place, mine < middle]


def main() -> None:
    """Print a line for each trial and how many were won."""
    parser = argparse.ArgumentParser(description="Is the proposed run better than a random one?")
    parser.add_argument("--trials", type=int, default=10)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--table", type=Path)
    asked = parser.parse_args()
    lines = []
    for number in range(asked.trials):
        with tempfile.TemporaryDirectory() as folder:
            lines.append(trial(number, asked.runs, Path(folder)))
        print(*lines[-1], flush=True)
    print(f"better than the median in {np.mean([line[-1] for line in lines]):.0%} of the trials")
    if asked.table is not None:
        with asked.table.open("w", newline="") as stream:
            csv.writer(stream, lineterminator="\n").writerows([HEADER, *lines])


if __name__ == "__main__":
    main()
