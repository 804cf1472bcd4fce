"""Orders of convergence, fitted: manufactured solutions in space, refined steps in time."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

from thermo.mesh import box_mesh, promote
from thermo.physics import (
    ConjugateGradient,
    Discretisation,
    Model,
    TimeGrid,
    discretise,
    solve_heat,
    uniform_steps,
)
from thermo.physics._quadrature import tetrahedron_rule
from thermo.physics._shape import cell_shape
from thermo.physics.effects import (
    Convection,
    Heating,
    LaggedRadiation,
    PolynomialLaw,
    Radiation,
    Schedule,
)
from thermo.physics.integrators import AbstractIntegrator, BackwardEuler, Sdirk2

simulate = eqx.filter_jit(solve_heat)
TIGHT = ConjugateGradient(rtol=1e-12)


def fitted(size: list[float], error: list[float]) -> float:
    """Slope of log(error) over log(size)."""
    return float(np.polyfit(np.log(size), np.log(error), 1)[0])


@final
class TwoLayers:
    """u = f(x) cos(p y + 0.3) cos(r z + 0.2) in a unit cube of two orthotropic layers.

    In each layer div(k grad u) = -rate capacity u, and temperature and flux pass x = 1/2 without
    a jump, so that one backward Euler step of `size` carries u to u / (1 + rate size) exactly.
    """

    rate, size, across, up = 9.0, 0.1, 1.7, 2.3
    conductivity = np.array([[1.0, 2.0, 0.5], [3.0, 0.7, 1.2]])
    capacity = np.array([1.5, 1.1])

    def parts(self, points: np.ndarray, layer: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """u and k grad u at points that lie in the given layers."""
        spent = self.conductivity[:, 1] * self.across**2 + self.conductivity[:, 2] * self.up**2
        q = np.sqrt((self.rate * self.capacity - spent) / self.conductivity[:, 0])
        x, y, z = np.moveaxis(points, -1, 0)
        at, slope = np.cos(q[0] / 2 + 0.4), -q[0] * np.sin(q[0] / 2 + 0.4)
        slope *= self.conductivity[0, 0] / self.conductivity[1, 0]
        s = q[1] * (x - 0.5)
        first = (np.cos(q[0] * x + 0.4), -q[0] * np.sin(q[0] * x + 0.4))
        second = (
            at * np.cos(s) + slope / q[1] * np.sin(s),
            slope * np.cos(s) - at * q[1] * np.sin(s),
        )
        f, df = (np.where(layer == 0, a, b) for a, b in zip(first, second, strict=True))
        cy, cz = np.cos(self.across * y + 0.3), np.cos(self.up * z + 0.2)
        sy, sz = np.sin(self.across * y + 0.3), np.sin(self.up * z + 0.2)
        gradient = np.stack([df * cy * cz, -self.across * f * sy * cz, -self.up * f * cy * sz], -1)
        return f * cy * cz, self.conductivity[layer] * gradient


def model_of(exact: TwoLayers, space: Discretisation, damping: float) -> Model:
    """Robin boundary with a coefficient that differs from face to face, and the flux it needs."""
    mesh = space.mesh
    cell_layer = (mesh.nodes[mesh.cells[:, :4]].mean(1)[:, 0] > 0.5).astype(int)
    face_layer = np.broadcast_to(cell_layer[mesh.owners][:, None], space.face_weight.shape)
    value, flow = exact.parts(np.asarray(space.face_point), face_layer)
    coefficient = 0.5 + mesh.nodes[mesh.faces[:, :3]].mean(1).sum(1)
    ambient = 0.7
    inward = np.einsum("fqx,fx->fq", flow, mesh.normals) * damping
    profile = inward + coefficient[:, None] * (damping * value - ambient)
    return Model(
        space,
        jnp.asarray(exact.conductivity[cell_layer][:, :, None] * np.eye(3)),
        jnp.asarray(exact.capacity[cell_layer]),
        surface=(
            Heating(1.0, profile, Schedule(1e9)),
            Convection(jnp.asarray(coefficient), ambient),
        ),
    )


def error_in_space(order: int, divisions: int) -> float:
    exact = TwoLayers()
    mesh = box_mesh((1.0, 1.0, 1.0), (divisions,) * 3)
    space = discretise(mesh if order == 1 else promote(mesh))
    mesh = space.mesh
    damping = 1 / (1 + exact.rate * exact.size)
    start, _ = exact.parts(mesh.nodes, (mesh.nodes[:, 0] > 0.5).astype(int))
    got = simulate(
        model_of(exact, space, damping),
        jnp.asarray(start),
        uniform_steps(np.array([exact.size]), exact.size),
        integrator=BackwardEuler(),
        solver=TIGHT,
    )
    assert bool(got.converged)
    points, weights = tetrahedron_rule(5)
    places = np.einsum("qa,cax->cqx", points, mesh.nodes[mesh.cells[:, :4]])
    layer = np.broadcast_to((places.mean(1)[:, None, 0] > 0.5).astype(int), places.shape[:2])
    value, _ = exact.parts(places, layer)
    ours = np.asarray(got.final)[mesh.cells] @ cell_shape(points, order).T
    return float(np.sqrt(((ours - damping * value) ** 2 @ weights) @ space.volume))


@pytest.mark.parametrize(("order", "divisions", "rate"), [(1, (6, 10, 16), 2), (2, (2, 4, 8), 3)])
def test_order_in_space(order: int, divisions: tuple[int, ...], rate: int) -> None:
    errors = [error_in_space(order, count) for count in divisions]
    slope = fitted([1 / count for count in divisions], errors)
    assert abs(slope - rate) < 0.1


DURATION, MOST = 40.0, 1024


def steps(count: int) -> TimeGrid:
    """`count` equal steps, and empty ones after them so that all runs share one program."""
    size = np.zeros(MOST)
    size[:count] = DURATION / count
    start = np.concatenate([[0.0], np.cumsum(size)[:-1]])
    return TimeGrid(start, size, np.array([MOST], np.int32), np.array([DURATION]))


def warmed(radiation: type, laws: bool) -> Model:
    """A hot box that cools unevenly, with a smooth lamp."""
    space = discretise(box_mesh((0.02, 0.02, 0.02), (2, 2, 2)))
    mesh = space.mesh
    centre = mesh.nodes[mesh.faces[:, :3]].mean(1) / 0.02
    return Model(
        space,
        jnp.asarray(1.0 + 50 * mesh.nodes[mesh.cells].mean(1)[:, 0]),
        jnp.full(len(mesh.cells), 1.5e5),
        surface=(
            Convection(jnp.asarray(10.0 + 20.0 * centre[:, 1]), 290.0),
            radiation(jnp.asarray(0.3 + 0.6 * centre[:, 0]), 300.0),
            Heating(1.0, 4e3 * centre[:, 2:] * np.ones((1, 3)), Schedule(1e9, 50.0)),
        ),
        conductivity_law=PolynomialLaw(jnp.array([1.0, 2e-3]), 300.0) if laws else None,
        capacity_law=PolynomialLaw(jnp.array([1.0, 1e-3, 2e-6]), 300.0) if laws else None,
    )


def run(model: Model, integrator: AbstractIntegrator, count: int) -> np.ndarray:
    start = jnp.full(len(model.space.mesh.nodes), 500.0)
    solution = simulate(model, start, steps(count), integrator=integrator, solver=TIGHT)
    assert bool(solution.converged)
    return np.asarray(solution.final)


def order_in_time(model: Model, integrator: AbstractIntegrator, reference: np.ndarray) -> float:
    counts = [16, 32, 64] if integrator.order() == 2 else [128, 256, 512]
    errors = [np.abs(run(model, integrator, n) - reference).max() for n in counts]
    return fitted([1 / n for n in counts], errors)


def test_order_in_time_with_radiation() -> None:
    model = warmed(Radiation, laws=False)
    reference = run(model, Sdirk2(), MOST)
    assert abs(order_in_time(model, Sdirk2(), reference) - 2) < 0.1
    assert abs(order_in_time(model, BackwardEuler(), reference) - 1) < 0.1
    lagged = warmed(LaggedRadiation, laws=False)
    assert abs(order_in_time(lagged, BackwardEuler(), reference) - 1) < 0.1


def test_order_in_time_with_properties_of_temperature() -> None:
    model = warmed(Radiation, laws=True)
    reference = run(model, Sdirk2(iterations=2), MOST)
    assert abs(order_in_time(model, Sdirk2(iterations=2), reference) - 2) < 0.1
    assert abs(order_in_time(model, BackwardEuler(iterations=2), reference) - 1) < 0.1
