"""The paper's cube simulated once more and more exactly, and what the given recordings differ by.

    python benchmarks/exact_cube.py SCENES [--cells 10] [--out outputs/exact]

A cube with a lamp on the middle of a face is symmetric: a quarter of it, in triquadratic cells that
grow thin towards its faces, takes few of them. By scikit-fem and TR-BDF2, from whose steps of 0.1 s
those after a switch are cut to as little as a 64th. Prints by run the root mean square of what the
recordings in SCENES differ by, and that of the ones in `--out` made before with another number of
`--cells`; leaves in `--out` the scene `cube` with its cooling and heating made anew, for
`coverage.py --cube`.
"""

from __future__ import annotations

import argparse
import json
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from hidden._heat import IMPLICIT, SIGMA
from numpy.typing import NDArray
from scipy.optimize import root_scalar
from scipy.sparse import csc_array
from scipy.sparse.linalg import SuperLU, splu
from skfem import Basis, ElementHex2, FacetBasis, LinearForm, MeshHex
from skfem.models.poisson import laplace, mass

HALF = 0.02
FRAME = 0.1
THIN = (1e-3, 8e-3)
"""First cell below the lit face and below the others [m], over the number of cells."""
# Of both rates before the last stage of TR-BDF2, over its step.
WEIGHT = np.sqrt(2.0) / 4
CUTS = (64, 16, 4, 4, 4, *[2] * 11)
"""Steps of the first frames after a switch [1]; one each of those after them."""
LOGGERS, SECOND = 16, 10
"""As in `coverage.py`: samples, and frames between two of their readings [1]."""

Values = NDArray[np.float64]


def graded(length: float, cells: int, thin: float) -> Values:
    """Ends of cells from -`length` to 0 [m], the last one `thin`, each before it longer."""
    powers = np.arange(cells)

    def too_long(ratio: float) -> float:
        return float(thin * np.sum(ratio**powers) - length)

    ratio = root_scalar(too_long, bracket=(1.0, 10.0)).root
    ends = np.cumsum(np.r_[0.0, thin * ratio**powers])
    return -ends[::-1] * length / ends[-1]


@dataclass
class Cube:
    """A quarter of the cube, x and y in [0, HALF], with its matrices in SI units."""

    material: dict[str, float]
    exchange: dict[str, float]
    conductivity: float
    cells: int

    def __post_init__(self) -> None:
        """Put together what does not change."""
        side = HALF + graded(HALF, self.cells + 2, THIN[1] / self.cells)
        top = HALF + graded(HALF, self.cells + 4, THIN[0] / self.cells)
        below = -HALF - graded(HALF, self.cells, THIN[1] / self.cells)
        mesh = MeshHex.init_tensor(side, side, np.unique(np.r_[below, top]))
        self.basis = Basis(mesh, ElementHex2(), intorder=5)
        outside = mesh.facets_satisfying(lambda x: np.abs(x).max(0) > HALF - 1e-9)
        self.outside = FacetBasis(mesh, ElementHex2(), facets=outside, intorder=5)
        lit = mesh.facets_satisfying(lambda x: x[2] > HALF - 1e-9)
        self.lit = FacetBasis(mesh, ElementHex2(), facets=lit, intorder=9)
        capacity = self.material["density"] * self.material["heat_capacity"]
        self.mass = csc_array(capacity * mass.assemble(self.basis))
        self.conduction = csc_array(self.conductivity * laplace.assemble(self.basis))
        self.surface = csc_array(mass.assemble(self.outside))

    def spot(self, radius: float) -> Values:
        """Nodal shares [1] of a quarter of the light."""
        bell = LinearForm(lambda v, w: np.exp(-(w.x[0] ** 2 + w.x[1] ** 2) / 2 / radius**2) * v)
        share = bell.assemble(self.lit)
        return share / share.sum() / 4


class Heat:
    """Nodal heat flows [W] in one run; radiation is in part linear and in part added."""

    def __init__(self, cube: Cube, run: dict[str, Any]) -> None:
        warm = run["radiation_temperature"]
        strength = cube.exchange["emissivity"] * SIGMA
        linear = 4 * strength * warm**3
        film = cube.exchange["convection"]
        self.cube, self.solvers = cube, dict[float, SuperLU]()
        self.loss = cube.conduction + (film + linear) * cube.surface
        ones = np.ones(cube.basis.N)
        self.given = film * run["ambient_temperature"] * (cube.surface @ ones)
        heater = run["heater"]
        self.light = heater["power"] * cube.spot(heater["radius"]) if heater else 0 * ones
        self.rest = LinearForm(
            lambda v, w: (strength * (w.T**4 - warm**4) - linear * w.T) * v
        )  # fmt: skip

    def added(self, heat: Values) -> Values:
        """What of radiation is not linear."""
        return self.rest.assemble(self.cube.outside, T=self.cube.outside.interpolate(heat))

    def flow(self, heat: Values, lit: bool) -> Values:
        """Into each node."""
        return self.given + lit * self.light - self.loss @ heat - self.added(heat)

    def implicit(self, right: Values, span: float, lit: bool, heat: Values) -> Values:
        """Temperatures u [K] with mass u - span flow(u) = right."""
        if span not in self.solvers:
            self.solvers[span] = splu(self.cube.mass + span * self.loss)
        right = right + span * (self.given + lit * self.light)
        for _ in range(10):
            new = self.solvers[span].solve(right - span * self.added(heat))
            apart, heat = np.abs(new - heat).max(), new
            if apart < 1e-6:
                return heat
        raise RuntimeError(f"radiation did not settle: {apart:.2g} K")

    def step(self, heat: Values, span: float, lit: bool) -> Values:
        """Temperatures after a step of TR-BDF2."""
        before, begun = self.cube.mass @ heat, self.flow(heat, lit)
        half = IMPLICIT * span
        between = self.implicit(before + half * begun, half, lit, heat)
        both = WEIGHT * span * (begun + self.flow(between, lit))
        return self.implicit(before + both, half, lit, between)


def course(cube: Cube, run: dict[str, Any], frames: int) -> Iterator[Values]:
    """Nodal temperatures [K] after each frame."""
    heat_flow = Heat(cube, run)
    heater = run["heater"]
    off = round(heater["until"] / FRAME) if heater else frames
    heat = np.full(cube.basis.N, float(run["initial_temperature"]))
    yield heat
    for frame in range(frames):
        lit = frame < off
        since = frame if lit else frame - off
        cuts = CUTS[since] if since < len(CUTS) else 1
        for _ in range(cuts):
            heat = heat_flow.step(heat, FRAME / cuts, lit)
        yield heat


def told(name: str, apart: Values) -> None:
    """Print the root mean squares of differences (frames, samples) [K]."""
    kept = np.linspace(0, apart.shape[1] - 1, LOGGERS).round().astype(int)
    parts = {
        "all": apart, "after 5 s": apart[50:], "sixteen loggers": apart[::SECOND, kept],
    }  # fmt: skip
    words = (f"{what} {1e3 * np.sqrt(np.mean(one**2)):.2g} mK" for what, one in parts.items())
    print(f"{name}: {', '.join(words)}", flush=True)


def main() -> None:
    """Make both runs, compare, keep them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", type=Path)
    parser.add_argument("--cells", type=int, default=10)
    parser.add_argument("--out", type=Path, default=Path("outputs/exact"))
    asked = parser.parse_args()
    given, made = asked.scenes / "cube", asked.out / "cube"
    scene = json.loads((given / "scene.json").read_text("utf-8"))
    cube = Cube(
        scene["material"], scene["surface_exchange"], scene["truth"]["conductivity"], asked.cells
    )
    scene["runs"] = {name: scene["runs"][name] for name in ("cooling", "heating")}
    made.mkdir(parents=True, exist_ok=True)
    for name, run in scene["runs"].items():
        with np.load(given / f"{name}.npz") as file:
            points, time, old = file["points"], file["time"], file["temperature"]
        at = np.abs(points.astype(float).T)
        at[2] = points[:, 2]
        read = cube.basis.probes(np.clip(at, -HALF, HALF) * (1 - 1e-12))
        new = np.stack([read @ heat for heat in course(cube, run, len(time) - 1)])
        told(f"{name}, given", old - new)
        if (path := made / f"{name}.npz").exists():
            with np.load(path) as file:
                told(f"{name}, made before", file["temperature"] - new)
        np.savez(path, points=points, time=time, temperature=new)
    shutil.copy(given / scene["surface"], made / scene["surface"])
    (made / "scene.json").write_text(json.dumps(scene), "utf-8")


if __name__ == "__main__":
    main()
