"""How often 95 % intervals hold the truth, over draws of a camera's noise on the paper's scenes.

    python benchmarks/coverage.py SCENES [--exact outputs/exact] [--draws 200] [--nodes 15000]

SCENES holds scenes that another program simulated without noise. On each, cooling and heating are
looked at together for a few values of the body, on a mesh of our own: by a camera (every sample and
frame of the scene, 720 000 readings) and by loggers (16 samples, one frame a second). What is left
wrong by cells and steps, and by those of the program that made the data, does not fall with the
number of readings; the noise does. A draw is noise of 0.05 K whose frames are correlated by 0.3, a
fixed pattern of 0.03 K and 25 quiet frames from which all of that is learnt. The fit is linear
around the truth, as its deviations of about a per cent and less allow.
`coverage` is of the interval from the curvature of what `log_model` makes, `scatter` the standard
deviation of the fits over the one that it foretells, `bias` their mean error over it; `identify` is
that of the interval that `thermo identify` gives after a fit of one value each, which allows for
what the fit may have left, up to a third, of what cells and steps make wrong. The columns of
`plain` are without what `mesh.corrected` does. A coverage of 200 draws is known to 1.5 %. `--exact`
adds the scenes that `exact_scenes.py` has simulated anew, which stand for the given ones in the
means. Leaves benchmarks/results/coverage.csv.
"""

from __future__ import annotations

import argparse
import csv
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from thermo.identify import identifiability
from thermo.inverse import (
    DEFECT_LEFT,
    DEFECT_SPREAD,
    NORMAL,
    Meshing,
    Sensitivity,
    Stepping,
    log_model,
)
from thermo.inverse._case import Case, constant_error, in_kelvin, make_case
from thermo.inverse._objective import Objective, case_temperatures, jacobian, start
from thermo.inverse._reading_errors import whiten, without
from thermo.inverse._sensitivity import logarithm_slopes
from thermo.inverse._stepping import fit_frames
from thermo.observe import Recording, Run, Scene, estimate_noise, read_scene
from thermo.physics import TimeGrid

RESULTS = Path(__file__).resolve().parent / "results" / "coverage.csv"
RUNS = ("cooling", "heating")
SCENES = ("cube", "cylinder", "bear")
READINGS: dict[str, tuple[int | None, int]] = {"camera": (None, 1), "loggers": (16, 10)}
UNKNOWN = ("conductivity", "volumetric_heat_capacity", "convection")
WHITE, PATTERN, CORRELATION, QUIET = 0.05, 0.03, 0.3, 25
MODEL_ERROR = 0.01
SEED = 1
"""Of the draws: what `DEFECT_SPREAD` is was decided with those of seed 0."""
COLUMNS = (
    "readings", "scene", "unknown", "draws", "sd", "coverage", "scatter", "bias", "plain coverage",
    "plain bias", "identify",
)  # fmt: skip


def drawn(run: Run, random: np.random.Generator) -> Run:
    """The run as a camera would have read it."""
    record = run.recording
    frames, samples = record.temperature.shape
    fresh = np.sqrt(1 - CORRELATION**2) * random.standard_normal((QUIET + frames, samples))
    fresh[[0, QUIET]] /= np.sqrt(1 - CORRELATION**2)
    for number in range(1, len(fresh)):
        if number != QUIET:
            fresh[number] += CORRELATION * fresh[number - 1]
    error = WHITE * fresh + PATTERN * random.standard_normal(samples)
    values = np.where(record.valid, record.temperature + error[QUIET:], np.nan)
    quiet = run.initial_temperature + error[:QUIET]
    return replace(run, recording=Recording(record.points, record.time, values, None, quiet))


def thinned(scene: Scene, samples: int | None, every: int) -> Scene:
    """The scene with so many of its samples [1], spread over its list, and every so many frames."""
    runs = {}
    for name, run in scene.runs.items():
        old = run.recording
        count = len(old.points)
        kept = np.linspace(0, count - 1, samples or count).round().astype(int)
        values = np.where(old.valid, old.temperature, np.nan)[::every, kept]
        record = Recording(old.points[kept], old.time[::every], values, None, None)
        runs[name] = replace(run, recording=record)
    return replace(scene, runs=runs)


@eqx.filter_jit
def _temperatures(objective: Objective, case: Case) -> Float[Array, "runs frames samples"]:
    return jax.lax.map(lambda one: case_temperatures(objective, objective.fields, one), case)


class Around:
    """A scene around its truth: temperatures, slopes and defects of each run on our mesh."""

    def __init__(self, folder: Path, nodes: int, samples: int | None, every: int) -> None:
        scene = thinned(read_scene(folder), samples, every)
        true = json.loads((folder / "scene.json").read_text("utf-8"))["truth"]
        known = {
            "conductivity": float(true["conductivity"]),
            "volumetric_heat_capacity": scene.material.volumetric_heat_capacity(),
        }
        stepping = Stepping(rtol=1e-6)
        model = log_model(
            scene, runs=RUNS, unknown=UNKNOWN, initial=known, stepping=stepping,
            meshing=Meshing(max_nodes=nodes), model_error=MODEL_ERROR,
        )  # fmt: skip
        plain = replace(model.objective, cases=tuple(map(in_kelvin, model.objective.cases)))
        here = start(plain)
        change = np.linalg.inv(logarithm_slopes(plain, here, UNKNOWN, "Uniform"))
        matrix = np.asarray(eqx.filter_jit(jacobian)(plain, here)[1]) @ change
        self.objective, self.most_frames = plain, stepping.most_frames
        self.runs = [scene.runs[name] for name in RUNS]
        self.values = tuple(np.exp(model.first).tolist())
        self.found, self.slopes, self.defect = {}, {}, {}
        names, begin = iter(RUNS[number] for number in plain.sequence), 0
        for case in plain.cases:
            slopes = matrix[begin : begin + case.data.size].reshape(*case.data.shape, -1)
            begin += case.data.size
            for parts in zip(_temperatures(plain, case), slopes, case.defect, strict=True):
                name = next(names)
                self.found[name], self.slopes[name], self.defect[name] = map(np.asarray, parts)

    def grid(self, run: Run) -> TimeGrid:
        """The frames that a fit takes."""
        return fit_frames(run, Stepping(most_frames=self.most_frames))

    def fit(
        self, noisy: list[Run], *, corrected: bool, doubted: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        """Errors of log(phi), and their deviations by the curvature [1]."""
        square, slope = np.zeros((len(UNKNOWN),) * 2), np.zeros(len(UNKNOWN))
        for run in noisy:
            case = make_case(
                run, self.objective.space, self.grid(run), model_error=MODEL_ERROR, where=run.name
            )
            here = tuple(slice(length) for length in case.data.shape)
            defect = jnp.asarray(self.defect[run.name][here])
            apart = self.found[run.name][here] - case.data - (0 if corrected else defect)
            series = np.concatenate(
                [np.asarray(apart)[..., None], self.slopes[run.name][here]], axis=-1
            )
            white = np.asarray(_white(case, jnp.asarray(series), doubted * DEFECT_LEFT * defect))
            rows = white.reshape(-1, white.shape[-1])
            square += rows[:, 1:].T @ rows[:, 1:]
            slope += rows[:, 1:].T @ rows[:, 0]
        covariance = np.linalg.inv(square)
        return -covariance @ slope, np.sqrt(np.diagonal(covariance))

    def told(self, noisy: list[Run]) -> np.ndarray:
        """Deviations of log(phi) by `thermo identify` [1]."""
        noise, staying = {}, {}
        for run in noisy:
            level = estimate_noise(run.recording)
            noise[run.name] = level.long_run()
            staying[run.name] = float(np.sqrt(np.mean(constant_error(run, level)[1])))
        left = {name: DEFECT_SPREAD * apart for name, apart in self.defect.items()}
        at = Sensitivity(UNKNOWN, self.slopes, noise, 1e-6, staying, self.values, left)
        told = identifiability(at, model_error=MODEL_ERROR).findings
        return np.array([item.relative for item in told])


@eqx.filter_jit
def _white(
    case: Case, series: Float[Array, "frames samples columns"], left: Float[Array, "frames samples"]
) -> Float[Array, "frames samples columns"]:
    shared = whiten(case.errors, case.used, left)
    each = jax.vmap(lambda one: without(shared, whiten(case.errors, case.used, one)), 2, 2)
    return each(series)


def rows(around: Around, draws: int) -> Iterator[tuple[str, list[float], float]]:
    """By unknown, the numbers of the table and the coverage [1]."""
    random, parts = np.random.default_rng(SEED), []
    for _ in range(draws):
        noisy = [drawn(run, random) for run in around.runs]
        best = around.fit(noisy, corrected=True, doubted=True)
        plain = around.fit(noisy, corrected=False, doubted=False)
        fitted, _ = around.fit(noisy, corrected=True, doubted=False)
        parts.append(np.stack([*best, *plain, fitted, around.told(noisy)]))
    error, sd, plain_error, plain_sd, fitted, told = np.stack(parts, axis=1)
    for place, quantity in enumerate(UNKNOWN):
        mine, mean, off = error[:, place], sd[:, place].mean(), plain_error[:, place]
        inside = float(np.mean(np.abs(mine) < NORMAL * sd[:, place]))
        yield quantity, [
            mean, inside, mine.std(ddof=1) / mean, mine.mean() / mean,
            np.mean(np.abs(off) < NORMAL * plain_sd[:, place]),
            off.mean() / plain_sd[:, place].mean(),
            np.mean(np.abs(fitted[:, place]) < NORMAL * told[:, place]),
        ], inside  # fmt: skip


def pooled(shares: dict[tuple[str, str], float]) -> float:
    """Mean [1] over all bodies, those made anew in place of the given ones."""
    kept = [one for (name, what), one in shares.items() if (f"exact {name}", what) not in shares]
    return float(np.mean(kept))


def main() -> None:
    """Print the table and write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", type=Path)
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--nodes", type=int, default=15_000)
    parser.add_argument("--exact", type=Path, help="where exact_scenes.py has left scenes")
    asked = parser.parse_args()
    folders = {name: asked.scenes / name for name in SCENES}
    if asked.exact:
        folders |= {f"exact {path.name}": path for path in sorted(asked.exact.iterdir())}
    lines = []
    for kind, (samples, every) in READINGS.items():
        covered, told = {}, {}
        for name, folder in folders.items():
            around = Around(folder, asked.nodes, samples, every)
            for quantity, row, inside in rows(around, asked.draws):
                lines.append([kind, name, quantity, asked.draws, *(f"{cell:.4g}" for cell in row)])
                covered[name, quantity], told[name, quantity] = inside, row[-1]
                print(*lines[-1], flush=True)
        print(f"{kind}: {pooled(covered):.3f} of all, {pooled(told):.3f} by thermo identify")
    with RESULTS.open("w", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows([COLUMNS, *lines])


if __name__ == "__main__":
    main()
