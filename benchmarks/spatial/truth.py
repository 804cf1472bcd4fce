"""Heat in a body whose conductivity varies from place to place, by another program.

scikit-fem's quadratic tetrahedra, the conductivity evaluated at every quadrature point, the
trapezoidal rule with damped half steps after each switch, radiation by Newton's method, and a
direct solver: nothing of it is shared with the package that is tested.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.sparse.linalg as spla
import skfem
from skfem.helpers import dot, grad

STEFAN_BOLTZMANN = 5.670374419e-8
QUIET = 1e-9
"""Change of a Newton iteration [K] at which a step is solved."""

Law = Callable[[np.ndarray], np.ndarray]
"""From points (3, ...) [m] to conductivities (...) [W/m/K]."""


class Body:
    """A body with its matrices.

    - `mesh`: linear tetrahedra [m]; `law`: its conductivity.
    - `capacity` [J/m3/K], `convection` [W/m2/K], `emissivity` [1].
    """

    def __init__(
        self, mesh: skfem.MeshTet, law: Law, capacity: float, convection: float, emissivity: float
    ) -> None:
        element = skfem.ElementTetP2()
        self.basis = skfem.Basis(mesh, element, intorder=4)
        self.rim = skfem.FacetBasis(mesh, element, intorder=4)
        self.mass = capacity * skfem.BilinearForm(lambda u, v, w: u * v).assemble(self.basis)
        conducting = skfem.BilinearForm(lambda u, v, w: law(w.x) * dot(grad(u), grad(v)))
        self.stiffness = conducting.assemble(self.basis).tocsc()
        self.convection, self.radiating = convection, emissivity * STEFAN_BOLTZMANN

    def lamp(self, centre: np.ndarray, direction: np.ndarray, radius: float) -> np.ndarray:
        """Share [1] of a spot lamp's power that each node takes."""
        axis = direction / np.linalg.norm(direction)

        def light(v, w):  # noqa: ANN001, ANN202
            offset = w.x - centre[:, None, None]
            across = offset - np.einsum("i,ifq->fq", axis, offset) * axis[:, None, None]
            facing = np.maximum(-np.einsum("i,ifq->fq", axis, w.n), 0)
            return np.exp(-(across**2).sum(0) / (2 * radius**2)) * facing * v

        load = skfem.LinearForm(light).assemble(self.rim)
        return load / load.sum()

    def exchange(self, state: np.ndarray, around: float) -> tuple[np.ndarray, object]:
        """Heat [W] that the surface takes from surroundings at `around` [K], and its slope."""
        hot = self.rim.interpolate(state)
        force = skfem.LinearForm(
            lambda v, w: (
                (self.convection * (around - w.t) + self.radiating * (around**4 - w.t**4)) * v
            )
        ).assemble(self.rim, t=hot)
        slope = skfem.BilinearForm(
            lambda u, v, w: (self.convection + 4 * self.radiating * w.t**3) * u * v
        ).assemble(self.rim, t=hot)
        return force, slope


def run(
    body: Body, start: float, around: float, heat: np.ndarray, until: float, end: float, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """Times (frames,) [s] and temperatures (frames, nodes) [K], a frame after each `step` [s].

    `heat`: [W] at each node for t < `until` [s].
    """
    state = np.full(body.mass.shape[0], start)
    _, slope = body.exchange(state, around)
    whole = spla.splu((body.mass / step + 0.5 * (body.stiffness + slope)).tocsc())
    half = spla.splu((body.mass / (step / 2) + body.stiffness + slope).tocsc())
    count = round(end / step)
    frames = [state]
    for number in range(count):
        now = number * step
        source = heat if now < until - 1e-9 else np.zeros_like(heat)
        # The trapezoidal rule rings after a jump; half steps of Euler's method damp it.
        fresh = number < 2 or abs(now - until) < 1e-9
        if fresh:
            for _ in range(2):
                state = _solve(body, half, state, source, around, step / 2, 1.0)
        else:
            state = _solve(body, whole, state, source, around, step, 0.5)
        frames.append(state)
    return np.arange(count + 1) * step, np.array(frames)


def _solve(
    body: Body,
    factor: spla.SuperLU,
    old: np.ndarray,
    source: np.ndarray,
    around: float,
    step: float,
    share: float,
) -> np.ndarray:
    """One step of the theta method, `share` of it implicit, by a Newton iteration."""

    def heat(state: np.ndarray) -> np.ndarray:
        return body.exchange(state, around)[0] - body.stiffness @ state + source

    before = (1 - share) * heat(old) if share < 1 else 0.0
    new = old.copy()
    while True:
        lack = before + share * heat(new) - body.mass @ (new - old) / step
        change = factor.solve(lack)
        new += change
        if np.abs(change).max() < QUIET:
            return new
