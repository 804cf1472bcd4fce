"""Some of the paper's scenes simulated once more, and how far the given recordings are from that.

    python benchmarks/exact_scenes.py SCENES [cube bear ...] [--coarser 1.0] [--out outputs/exact]

By scikit-fem and TR-BDF2, from whose steps of 0.1 s those after a switch are cut to as little as a
64th. A cube with a lamp on the middle of a face is symmetric: a quarter of it, in triquadratic
cells that grow thin towards its faces, takes few of them. Any other body is filled with quadratic
tetrahedra, on the bear twice as many as the finer mesh of a fit has, which hold the volume of its
surface to a hundred-thousandth. Prints by run the root mean square of what the recordings in SCENES
differ by, and that of the ones in `--out` made before with another `--coarser`; leaves in `--out`
the scenes with their cooling and heating made anew, for `coverage.py --exact`.
"""

from __future__ import annotations

import argparse
import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from hidden._heat import IMPLICIT, SIGMA
from numpy.typing import NDArray
from scipy.optimize import root_scalar
from scipy.sparse import csc_array, csr_array, diags_array
from scipy.sparse.linalg import cg, splu
from skfem import Basis, ElementHex2, ElementTetP2, FacetBasis, LinearForm, MeshHex, MeshTet
from skfem.models.poisson import laplace, mass

from thermo.mesh import Sizing, locate, read_surface, tetrahedralise

HALF = 0.02
FRAME = 0.1
CELLS = 10
"""Of the cube along half an edge [1]."""
THIN = (1e-3, 8e-3)
"""First cell below the lit face and below the others [m], over the number of cells."""
SIZING = (1e-3, 2.5e-3, 5e-3)
"""Edges of tetrahedra at the surface and inside, and how deep the first reach [m]."""
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


class Body(Protocol):
    """Matrices of a body in SI units, and what its recordings read."""

    basis: Basis
    outside: FacetBasis
    mass: csr_array
    conduction: csr_array
    surface: csr_array

    def spot(self, heater: dict[str, Any]) -> Values:
        """Nodal heat under the lamp [W]."""
        ...

    def solver(self, matrix: csr_array) -> Callable[[Values, Values], Values]:
        """To solve with a matrix, from a right side and a guess."""
        ...

    def reading(self, points: Values) -> csr_array:
        """From nodes to temperatures at points [m] of the surface."""
        ...


class Cube:
    """A quarter of the cube, x and y in [0, HALF]."""

    def __init__(self, scene: dict[str, Any], surface: Path, coarser: float) -> None:
        cells = round(CELLS / coarser)
        side = HALF + graded(HALF, cells + 2, THIN[1] / cells)
        top = HALF + graded(HALF, cells + 4, THIN[0] / cells)
        below = -HALF - graded(HALF, cells, THIN[1] / cells)
        mesh = MeshHex.init_tensor(side, side, np.unique(np.r_[below, top]))
        self.basis = Basis(mesh, ElementHex2(), intorder=5)
        outside = mesh.facets_satisfying(lambda x: np.abs(x).max(0) > HALF - 1e-9)
        self.outside = FacetBasis(mesh, ElementHex2(), facets=outside, intorder=5)
        lit = mesh.facets_satisfying(lambda x: x[2] > HALF - 1e-9)
        self.lit = FacetBasis(mesh, ElementHex2(), facets=lit, intorder=9)
        self.mass, self.conduction, self.surface = matrices(self.basis, self.outside, scene)

    def spot(self, heater: dict[str, Any]) -> Values:
        """Of a quarter of the light."""
        return heater["power"] / 4 * shares(self.lit, heater)

    def solver(self, matrix: csr_array) -> Callable[[Values, Values], Values]:
        """By its factors."""
        factors = splu(csc_array(matrix))
        return lambda right, guess: factors.solve(right)

    def reading(self, points: Values) -> csr_array:
        """All quarters are alike."""
        at = np.abs(points.T)
        at[2] = points[:, 2]
        return csr_array(self.basis.probes(np.clip(at, -HALF, HALF) * (1 - 1e-12)))


class Filled:
    """A body in quadratic tetrahedra."""

    def __init__(self, scene: dict[str, Any], surface: Path, coarser: float) -> None:
        skin, core, depth = (coarser * length for length in SIZING)
        self.linear = tetrahedralise(read_surface(surface), Sizing(skin, core, depth))
        mesh = MeshTet(self.linear.nodes.T, self.linear.cells.T)
        self.basis = Basis(mesh, ElementTetP2(), intorder=4)
        self.outside = FacetBasis(mesh, ElementTetP2(), intorder=6)
        self.mass, self.conduction, self.surface = matrices(self.basis, self.outside, scene)

    def spot(self, heater: dict[str, Any]) -> Values:
        """Of the whole light."""
        return heater["power"] * shares(self.outside, heater)

    def solver(self, matrix: csr_array) -> Callable[[Values, Values], Values]:
        """By conjugate gradients: heat that is stored outweighs what is conducted in a step."""
        light = diags_array(1 / matrix.diagonal())

        def solve(right: Values, guess: Values) -> Values:
            rest = right - matrix @ guess
            size = np.sqrt(rest @ (light @ rest) / (guess @ (matrix @ guess)))
            if size < 1e-12:
                return guess
            more, failed = cg(matrix, rest, rtol=1e-6, M=light)
            if failed:
                raise RuntimeError("conjugate gradients did not converge")
            return guess + more

        return solve

    def reading(self, points: Values) -> csr_array:
        """Where they are nearest to the surface, seen as lying inside."""
        found = locate(self.linear, points)
        foot = np.einsum("sk,ski->si", found.weights, self.linear.nodes[found.nodes])
        inner = foot - 1e-9 * self.linear.normals[found.face]
        return csr_array(self.basis.probes(inner.T))


def matrices(
    basis: Basis, outside: FacetBasis, scene: dict[str, Any]
) -> tuple[csr_array, csr_array, csr_array]:
    """Heat capacity [J/K], conductance [W/K] and area [m2]."""
    material = scene["material"]
    capacity = material["density"] * material["heat_capacity"]
    stiff = scene["truth"]["conductivity"] * laplace.assemble(basis)
    return (
        csr_array(capacity * mass.assemble(basis)), csr_array(stiff),
        csr_array(mass.assemble(outside)),
    )  # fmt: skip


def shares(lit: FacetBasis, heater: dict[str, Any]) -> Values:
    """Nodal shares of the light on a part of the skin [1]."""
    way, centre = np.array(heater["direction"]), np.array(heater["centre"])

    @LinearForm
    def bell(v: Any, w: Any) -> Any:
        apart = w.x - centre[:, None, None]
        square = (apart**2).sum(0) - np.einsum("i,ijk->jk", way, apart) ** 2
        faced = np.maximum(-np.einsum("i,ijk->jk", way, w.n), 0)
        return np.exp(-square / 2 / heater["radius"] ** 2) * faced * v

    share = bell.assemble(lit)
    return share / share.sum()


class Heat:
    """Nodal heat flows [W] in one run; radiation is in part linear and in part added."""

    def __init__(self, body: Body, exchange: dict[str, float], run: dict[str, Any]) -> None:
        warm = run["radiation_temperature"]
        strength = exchange["emissivity"] * SIGMA
        linear = 4 * strength * warm**3
        film = exchange["convection"]
        self.body, self.solvers = body, dict[float, Callable[[Values, Values], Values]]()
        self.loss = csr_array(body.conduction + (film + linear) * body.surface)
        ones = np.ones(body.basis.N)
        self.given = film * run["ambient_temperature"] * (body.surface @ ones)
        self.light = body.spot(run["heater"]) if run["heater"] else 0 * ones
        self.rest = LinearForm(
            lambda v, w: (strength * (w.T**4 - warm**4) - linear * w.T) * v
        )  # fmt: skip

    def added(self, heat: Values) -> Values:
        """What of radiation is not linear."""
        return self.rest.assemble(self.body.outside, T=self.body.outside.interpolate(heat))

    def flow(self, heat: Values, lit: bool) -> Values:
        """Into each node."""
        return self.given + lit * self.light - self.loss @ heat - self.added(heat)

    def implicit(self, right: Values, span: float, lit: bool, heat: Values) -> Values:
        """Temperatures u [K] with mass u - span flow(u) = right."""
        if span not in self.solvers:
            self.solvers[span] = self.body.solver(csr_array(self.body.mass + span * self.loss))
        right = right + span * (self.given + lit * self.light)
        for _ in range(10):
            new = self.solvers[span](right - span * self.added(heat), heat)
            apart, heat = np.abs(new - heat).max(), new
            if apart < 1e-6:
                return heat
        raise RuntimeError(f"radiation did not settle: {apart:.2g} K")

    def step(self, heat: Values, span: float, lit: bool) -> Values:
        """Temperatures after a step of TR-BDF2."""
        before, begun = self.body.mass @ heat, self.flow(heat, lit)
        half = IMPLICIT * span
        between = self.implicit(before + half * begun, half, lit, heat)
        both = WEIGHT * span * (begun + self.flow(between, lit))
        return self.implicit(before + both, half, lit, between)


def course(heat_flow: Heat, run: dict[str, Any], frames: int) -> Iterator[Values]:
    """Nodal temperatures [K] after each frame."""
    heater = run["heater"]
    off = round(heater["until"] / FRAME) if heater else frames
    heat = np.full(heat_flow.body.basis.N, float(run["initial_temperature"]))
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


def make(given: Path, made: Path, coarser: float) -> None:
    """Both runs of one scene, compared and kept."""
    scene = json.loads((given / "scene.json").read_text("utf-8"))
    kind = Cube if given.name == "cube" else Filled
    body: Body = kind(scene, given / scene["surface"], coarser)
    scene["runs"] = {name: scene["runs"][name] for name in ("cooling", "heating")}
    made.mkdir(parents=True, exist_ok=True)
    for name, run in scene["runs"].items():
        with np.load(given / f"{name}.npz") as file:
            points, time, old = file["points"], file["time"], file["temperature"]
        read = body.reading(points.astype(float))
        heat = Heat(body, scene["surface_exchange"], run)
        new = np.stack([read @ nodes for nodes in course(heat, run, len(time) - 1)])
        told(f"{given.name}, {name}, given", old - new)
        if (path := made / f"{name}.npz").exists():
            with np.load(path) as file:
                told(f"{given.name}, {name}, made before", file["temperature"] - new)
        np.savez(path, points=points, time=time, temperature=new)
    shutil.copy(given / scene["surface"], made / scene["surface"])
    (made / "scene.json").write_text(json.dumps(scene), "utf-8")


def main() -> None:
    """Make the scenes that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", type=Path)
    parser.add_argument("names", nargs="*", default=["cube", "bear"])
    parser.add_argument("--coarser", type=float, default=1.0)
    parser.add_argument("--out", type=Path, default=Path("outputs/exact"))
    asked = parser.parse_args()
    for name in asked.names:
        make(asked.scenes / name, asked.out / name, asked.coarser)


if __name__ == "__main__":
    main()
