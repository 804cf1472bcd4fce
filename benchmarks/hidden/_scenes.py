"""Scene folders with something hidden in them, and how visible that is."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from pathlib import Path
from types import MappingProxyType

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from hidden._bodies import Body, body
from hidden._effects import FORMS, OUTSIDE, PAIRS, WITHIN, Hidden, in_depth_absorption
from hidden._heat import COLD, Lamp, Physics, simulate

SAMPLES, END, FRAME, TICK = 160, 60.0, 0.5, 0.1
HOT = COLD + 58.0
QUIET = 25
SHAPES = {
    "block": ("steatite", "steel"), "plate": ("steatite", "titanium"),
    "cylinder": ("titanium", "steel"), "ell": ("steatite", "steel"),
    "dome": ("titanium", "steatite"),
}  # fmt: skip
OTHERS = {"arch": ("glass", "bronze"), "wedge": ("bronze", "glass")}
"""Bodies and materials on which nothing was settled: they were made when the search was done."""

SURFACES = {
    "bracket": ("steatite", "titanium"), "pinion": ("titanium", "steel"),
    "spot": ("glass", "steatite"), "rocker_arm": ("steel", "titanium"),
}  # fmt: skip
"""Bodies whose surfaces are files of a folder: parts with holes and teeth, a cow, a casting."""

CURVED = ("dome", "arch", "pinion", "spot", "rocker_arm")
"""Bodies on which a lamp may meet no flat face."""

MATERIALS = {
    "steel": (7900.0, 500.0, 15.1), "titanium": (4430.0, 560.0, 6.7),
    "steatite": (2700.0, 900.0, 2.8), "glass": (2500.0, 840.0, 1.0),
    "bronze": (8800.0, 380.0, 60.0),
}  # fmt: skip
NOISES = {"white": (0.05, 0.0, 0.0), "pattern": (0.05, 0.05, 0.0), "correlated": (0.05, 0.03, 0.4)}
"""By kind: of a reading [K], of a sample [K], correlation from frame to frame [1]."""

LAMPS: dict[str, Lamp | None] = {
    "lamp": Lamp((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), 0.011, 5.0, 30.0, 1.0),
    "cooling": None,
    "held_out": Lamp((0.0, 0.004, 0.0), (0.0, 0.0, 1.0), 0.01, 3.5, 40.0, 1.0),
}
FITTED = ("lamp", "cooling")
CUTS, SHORTER = 3, 2.0
"""Of the best recordings: cuts of the cells at the skin, steps to the usual one [1]."""

LAYERED = (1, 2)
"""Cuts and layers of the best recordings of `OTHERS` [1]: cuts across the longest edges leave cells
nearly as thick as they were, and below glass that has just been lit that shows by 4 mK."""

CUT_ONCE = 1
"""The same of `SURFACES` [1]: where cells follow a surface one cut makes four times as many."""

VISIBLE = 8.0
"""Effects are drawn until they are visible at this many deviations of the noise [1]."""

ALIKE = 1.2
"""Of two effects that show alike, how many times more visible one is at the most [1]."""

Readings = dict[str, np.ndarray]


Makers = tuple[Callable[[np.random.Generator, Body], Hidden], ...]


class NothingDrawnError(Exception):
    """A case that cannot be made: what may be hidden there is hardly seen, or never alike."""


def initial(run: str) -> float:
    """Temperature at which a run begins [K]."""
    return HOT if run == "cooling" else COLD


@dataclass(frozen=True)
class Case:
    """A scene to be made: a body, a noise, a seed, and who makes what is hidden."""

    group: str
    shape: str
    material: str
    noise: str
    seed: int
    makers: Makers = ()

    def name(self) -> str:
        """Of its folder."""
        made = "+".join(one.__name__ for one in self.makers) or "clean"
        return f"{self.group}-{made}-{self.shape}-{self.material}-{self.noise}-{self.seed}"


def cases(
    clean: int, draws: int, bodies: Mapping[str, tuple[str, str]] = MappingProxyType(SHAPES)
) -> list[Case]:
    """The suite, body by body: those of one body share meshes and compiled programs."""
    groups: list[tuple[str, int, Sequence[Makers]]] = [
        ("clean", clean, ((),)),
        ("within", draws, tuple((one,) for one in WITHIN)),
    ]
    groups += [("outside", draws, tuple((one,) for one in OUTSIDE)), ("pair", draws // 2, PAIRS)]
    return _spread(groups, bodies)


def forms(draws: int, bodies: Mapping[str, tuple[str, str]]) -> list[Case]:
    """Effects of the library at places that are no bells and no boxes where it has these."""
    return _spread([("form", draws, tuple((one,) for one in FORMS))], bodies)


def _spread(
    groups: Sequence[tuple[str, int, Sequence[Makers]]], bodies: Mapping[str, tuple[str, str]]
) -> list[Case]:
    """So many cases of each, over bodies, materials and kinds of noise."""
    shapes, noises = list(bodies), list(NOISES)
    flat = next(one for one in shapes if one not in CURVED)
    found = []
    for group, count, all_ in groups:
        for number, makers in enumerate(all_):
            for seed in range(count):
                turn = seed + 2 * number
                shape = shapes[turn % len(shapes)]
                if in_depth_absorption in makers and shape in CURVED:
                    shape = flat  # its light is absorbed below a flat face
                material = bodies[shape][turn // len(shapes) % 2]
                noise = noises[(turn // 10 + turn) % 3]
                found.append(Case(group, shape, material, noise, seed, makers))
    return sorted(found, key=lambda one: (one.shape, one.material))


def alike(draws: int, bodies: Mapping[str, tuple[str, str]]) -> list[Case]:
    """Pairs of the suite whose two effects show alike, so that neither alone explains much."""
    pairs = (one for one in cases(0, draws, bodies) if one.group == "pair")
    return [replace(one, group="alike") for one in pairs]


def exactness(bodies: Mapping[str, tuple[str, str]]) -> Iterator[tuple[str, float]]:
    """What the best recordings under the lamp differ by from the next best [K].

    Those have one cut less and longer steps; of `OTHERS` cuts in place of layers, and the same
    steps.
    """
    for shape, material in ((one, each) for one, both in bodies.items() for each in both):
        cuts = CUT_ONCE if shape in SURFACES else CUTS
        ways = ((cuts, 1, SHORTER), (cuts - 1, 1, SHORTER / 2))
        if shape in OTHERS:
            ways = ((*LAYERED, SHORTER), (CUTS, 1, SHORTER))
        best, less = (
            readings(
                body(shape, SAMPLES, seed=1, finer=cuts, layers=layers), stated(material),
                runs=("lamp",), finer=steps,
            )["lamp"]
            for cuts, layers, steps in ways
        )  # fmt: skip
        yield f"{shape} of {material}", float(np.sqrt(np.mean((best - less) ** 2)))


def lacking(shape: str, material: str) -> Readings:
    """What cells short at the skin and short steps read more where nothing is hidden [K].

    Added to what the usual ones read, where something is hidden as well: to make each case on these
    would take many times as long. How much of it what is hidden changes is not known, but for light
    that is absorbed below the skin, whose cases are made on these.
    """
    plain = stated(material)
    best = readings(short_cells(shape), plain, finer=SHORTER)
    usual = readings(the_body(shape), plain)
    return {run: value - usual[run] for run, value in best.items()}


def short_cells(shape: str) -> Body:
    """A body with cells short at the skin."""
    cuts, layers = LAYERED if shape in OTHERS else (CUT_ONCE if shape in SURFACES else CUTS, 1)
    return body(shape, SAMPLES, seed=1, finer=cuts, layers=layers)


@cache
def the_body(shape: str) -> Body:
    """Each body is made once."""
    return body(shape, SAMPLES, seed=1)


def stated(material: str) -> Physics:
    """What is true of a material but for what is hidden."""
    return Physics(*MATERIALS[material])


def readings(
    where: Body, physics: Physics, changed: Callable[[Lamp], Lamp] = lambda one: one,
    runs: Sequence[str] = tuple(LAMPS), finer: float = 1.0,
) -> Readings:  # fmt: skip
    """What the samples are at, by run, every `TICK` [K]; `finer`: steps to the usual one [1]."""
    tick = np.arange(round((END + 4.0) / TICK) + 1) * TICK
    found = {}
    for run in runs:
        lamp = LAMPS[run]
        lamp = changed(lamp) if lamp else None
        time, values = simulate(where, physics, lamp, initial(run), tick[-1], finer)
        # Smooth from switch to switch.
        ends = [0.0, *([lamp.until] if lamp else []), tick[-1]]
        made = np.zeros((len(tick), values.shape[1]))
        for low, high in zip(ends[:-1], ends[1:], strict=True):
            some = (time >= low - 1e-9) & (time <= high + 1e-9)
            there = (tick >= low - 1e-9) & (tick <= high + 1e-9)
            made[there] = CubicSpline(time[some], values[some])(tick[there])
        found[run] = made
    return found


def kept(folder: Path, name: str, make: Callable[[], Readings]) -> Readings:
    """Readings [K] that are made once and kept in a file."""
    path = folder / f"{name}.npz"
    if path.exists():
        with np.load(path) as file:
            return dict(file)
    made = make()
    folder.mkdir(parents=True, exist_ok=True)
    whole = folder / f"{name}.{os.getpid()}.tmp.npz"
    np.savez(whole, **made)
    whole.replace(path)
    return made


@dataclass(frozen=True)
class Made:
    """A case that was made: what is hidden, and its visible size in deviations of noise [1]."""

    hidden: list[Hidden]
    visible: list[float]


def make(case: Case, folder: Path, usual: Path) -> Made:
    """Write the scene of a case; `usual` keeps what several cases share.

    What is hidden is drawn again until all of it is visible.
    """
    random = np.random.default_rng([case.seed, *map(ord, case.name())])
    plain, where = stated(case.material), the_body(case.shape)
    drawn = _drawn(case, random, where, usual)
    hidden, shown, visible = ([one[key] for one in drawn] for key in range(3))
    physics, said, lamp = plain, plain, (lambda one: one)
    for one in hidden:
        physics, said = one.physics(physics), one.stated(said)
        lamp = _after(lamp, one.lamp)
    if physics.deep:
        # What the usual cells make wrong is another thing where light is absorbed below the skin.
        found = readings(short_cells(case.shape), physics, lamp, finer=SHORTER)
    else:
        found = _corrected(case, hidden, shown, physics, lamp, usual)
    tick = np.arange(len(found["lamp"])) * TICK
    quiet = {run: np.full_like(value, initial(run)) for run, value in found.items()}
    for one in hidden:
        # What reads wrongly did so before the run as well.
        found, quiet = (
            {run: one.read(tick, value, where.points) for run, value in readings.items()}
            for readings in (found, quiet)
        )
    _write(case, folder, said, found, {run: value[0] for run, value in quiet.items()}, random)
    return Made(hidden, visible)


def _corrected(
    case: Case, hidden: list[Hidden], shown: list[Readings], physics: Physics,
    lamp: Callable[[Lamp], Lamp], usual: Path,
) -> Readings:  # fmt: skip
    """All runs on the usual cells [K], with what these lack where nothing is hidden."""
    where, name = the_body(case.shape), f"{case.shape}-{case.material}"
    if all(not one.simulated() for one in hidden):
        found = kept(usual, name, lambda: readings(where, stated(case.material)))
    else:
        # A single effect was simulated in the fitted runs when its size was measured.
        done = shown[0] if len(hidden) == 1 else {}
        found = done | readings(where, physics, lamp, [run for run in LAMPS if run not in done])
    short = kept(usual, f"{name}-lacking", lambda: lacking(case.shape, case.material))
    return {run: value + short[run] for run, value in found.items()}


def _drawn(
    case: Case, random: np.random.Generator, where: Body, usual: Path
) -> tuple[tuple[Hidden, Readings, float], ...]:
    """Of each maker what it hides, how that reads in the fitted runs [K], how visible it is [1].

    Raises `NothingDrawnError` where nothing that was drawn is visible, or of a pair alike.
    """
    tried: list[list[tuple[Hidden, Readings, float]]] = [[] for _ in case.makers]
    # Any of the first may go with any of the second, so that a few of each are many pairs.
    for _ in range(15 if case.group == "alike" else 60):
        hidden = [one(random, where) for one in case.makers]
        for one, kept_ in zip(hidden, tried, strict=True):
            there = _shown(one, case, usual)
            kept_.append((one, there, _visible(there, one, case, usual)))
        last = [one[-1:] for one in tried]
        for drawn in product(*(tried if case.group == "alike" else last)):
            visible = [one[2] for one in drawn]
            like = case.group != "alike" or max(visible) <= ALIKE * min(visible)
            if not drawn or (like and min(visible) >= VISIBLE):
                return drawn
    raise NothingDrawnError(f"{case.name()}: nothing visible, or alike, was drawn")


def _after(one: Callable[[Lamp], Lamp], other: Callable[[Lamp], Lamp]) -> Callable[[Lamp], Lamp]:
    return lambda lamp: other(one(lamp))


def _shown(hidden: Hidden, case: Case, usual: Path) -> Readings:
    """The fitted runs with an effect [K]."""
    plain, where = stated(case.material), the_body(case.shape)
    if hidden.simulated():
        return readings(where, hidden.physics(plain), hidden.lamp, FITTED)
    base = kept(usual, f"{case.shape}-{case.material}", lambda: readings(where, plain))
    tick = np.arange(len(base["lamp"])) * TICK
    return {run: hidden.read(tick, base[run], where.points) for run in FITTED}


def _visible(there: Readings, hidden: Hidden, case: Case, usual: Path) -> float:
    """Size of the change in the fitted runs that conductivity and convection leave over [1]."""
    name, where = f"{case.shape}-{case.material}", the_body(case.shape)
    said = hidden.stated(stated(case.material))
    dark = "-dark" if said.emissivity == 0 else ""
    ways = {
        "": said,
        "-conductivity": replace(said, conductivity=1.02 * said.conductivity),
        "-convection": replace(said, convection=1.1 * said.convection),
    }
    base = {
        way: kept(usual, name + dark + way, lambda one=one: readings(where, one))
        for way, one in ways.items()
    }

    def change(of: Readings) -> np.ndarray:
        every, last = round(FRAME / TICK), round(END / TICK) + 1
        return np.concatenate([(of[run] - base[""][run])[:last:every].ravel() for run in FITTED])

    size, _, correlation = NOISES[case.noise]
    size *= np.sqrt((1 + correlation) / (1 - correlation))
    free = np.stack([change(base[way]) for way in ways if way], 1)
    left = change(there)
    left = left - free @ np.linalg.lstsq(free, left, rcond=None)[0]
    return float(np.linalg.norm(left)) / size


def _write(
    case: Case, folder: Path, said: Physics, found: Readings, quiet: Readings,
    random: np.random.Generator,
) -> None:  # fmt: skip
    folder.mkdir(parents=True, exist_ok=True)
    where = the_body(case.shape)
    where.surface.export(folder / "surface.ply")
    every, last = round(FRAME / TICK), round(END / TICK) + 1
    size, pattern, correlation = NOISES[case.noise]
    runs = {}
    for run, values in found.items():
        frames = np.concatenate([np.tile(quiet[run], (QUIET, 1)), values[:last:every]])
        fresh = random.standard_normal(frames.shape)
        fresh[1:] *= np.sqrt(1 - correlation**2)
        frames += size * lfilter([1.0], [1.0, -correlation], fresh, axis=0)
        frames += pattern * random.standard_normal(frames.shape[1])
        np.savez(
            folder / f"{run}.npz", points=where.points, temperature=frames[QUIET:],
            time=np.arange(len(frames) - QUIET) * FRAME, quiet=frames[:QUIET],
        )  # fmt: skip
        lamp = LAMPS[run]
        runs[run] = {
            "recording": f"{run}.npz", "initial_temperature": initial(run),
            "ambient_temperature": COLD, "radiation_temperature": COLD,
            "held_out": run == "held_out",
            "heater": None if lamp is None else {
                "kind": "spot", "centre": lamp.centre, "direction": lamp.direction,
                "radius": lamp.radius, "power": lamp.power, "until": lamp.until, "rise": lamp.rise,
            },
        }  # fmt: skip
    # Alike for all cases of a body: meshes are made for what is stated.
    guess = np.random.default_rng([*map(ord, case.shape + case.material)])
    wrong = float(np.exp(guess.uniform(np.log(0.7), np.log(1.5))))
    scene = {
        "format": "thermofield-scene/1", "object": case.shape, "surface": "surface.ply",
        "material": {
            "density": said.density, "heat_capacity": said.capacity,
            "conductivity": wrong * said.conductivity,
        },
        "surface_exchange": {"convection": said.convection, "emissivity": said.emissivity},
        "unknown": ["conductivity", "convection"], "prior": {"convection_relative_sd": 0.3},
        "runs": runs,
    }  # fmt: skip
    (folder / "scene.json").write_text(json.dumps(scene, indent=1), "utf-8")
