"""Rows 4, 5, 6 and 22 of the verification table, and an orthotropic box as a stretched one."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from thermo.mesh import ball_mesh, box_mesh, promote
from thermo.physics import Model, discretise, every_node, uniform_steps
from thermo.physics.effects import Convection, PrescribedFlux
from thermo.physics.integrators import BackwardEuler, Sdirk2

from .bodies import (
    at_points,
    constant,
    everywhere,
    growing_steps,
    held,
    in_cells,
    on_faces_towards,
    simulate,
)
from .closed_forms import (
    convective_ball_centre,
    flux_slab,
    plate_with_two_convective_sides,
    step_slab,
)

HALVES = (1.0, 1.6, 2.0)
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def eighth():
    """An eighth of the box 2 x 3.2 x 4: the planes through its centre are adiabatic."""
    return discretise(promote(box_mesh(HALVES, (5, 8, 10))))


def test_ttlv301_step_on_all_faces() -> None:
    space = eighth()
    outer = (space.mesh.nodes > np.array(HALVES) - 1e-9).any(1)
    model = Model(
        space,
        in_cells(space, 1.0),
        in_cells(space, 1.0),
        prescribed=held(space, (outer, constant(2))),
    )
    times = np.array([0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.2])
    points = np.array([(0.0, 0.0, 0.0), (0.5, 0.8, 1.0)])
    got = simulate(
        model,
        everywhere(space, 1.0),
        growing_steps(times, 0.002, 1.12),
        integrator=Sdirk2(),
        readout=at_points(space, points),
    ).temperature
    shares = [
        step_slab(points[:, axis], times, length=HALVES[axis], diffusivity=1.0) for axis in range(3)
    ]
    exact = 2 - np.prod(shares, axis=0)
    stated = [
        [1.05137, 1.24768, 1.45136, 1.73684, 1.88010, 1.96406, 1.98398],
        [1.33579, 1.61081, 1.75959, 1.90017, 1.95657, 1.98723, 1.99433],
    ]
    np.testing.assert_allclose(exact.T, stated, atol=2e-5)
    np.testing.assert_allclose(got, exact, atol=2e-3)


def test_ttlv300_flux_into_all_faces() -> None:
    space = eighth()
    flux = PrescribedFlux(on_faces_towards(space, *AXES, value=0.5))
    model = Model(space, in_cells(space, 1.0), in_cells(space, 1.0), surface=(flux,))
    times = np.array([0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 5.0, 10.0])
    points = np.array([(0.0, 0.0, 0.0), HALVES])
    got = simulate(
        model,
        everywhere(space, 1.0),
        growing_steps(times, 0.002, 1.12),
        integrator=Sdirk2(),
        readout=at_points(space, points),
    ).temperature
    rises = [
        0.5 * HALVES[axis] * flux_slab(points[:, axis], times, length=HALVES[axis], diffusivity=1.0)
        for axis in range(3)
    ]
    exact = 1 + np.sum(rises, axis=0)
    stated = [1.0001, 1.00398, 1.03331, 1.08533, 1.23086, 1.69979, 5.9292, 11.242]
    np.testing.assert_allclose(exact[:, 0], stated, rtol=1e-4)
    np.testing.assert_allclose(exact[[5, 7], 1], [2.80854, 12.39167], atol=1e-5)
    np.testing.assert_allclose(got, exact, atol=2e-3)


def test_sphere_in_hot_gas() -> None:
    times = np.arange(400.0, 2401.0, 200.0)
    # Flat faces hold less than the ball: a radius that gives the ball's volume, and a coefficient
    # that gives its total exchange, leave only the unevenness of the surface.
    inside = ball_mesh(0.1, 4).volume() / (4 / 3 * np.pi * 0.1**3)
    space = discretise(promote(ball_mesh(0.1 * inside ** (-1 / 3), 4)))
    excess = space.mesh.area() / (4 * np.pi * 0.1**2)
    every_face = jnp.full(len(space.mesh.faces), 232.5 / excess)
    model = Model(
        space,
        in_cells(space, 48.822),
        in_cells(space, 4816800.0),
        surface=(Convection(every_face, 1000.0),),
    )
    got = simulate(
        model,
        everywhere(space, 20.0),
        uniform_steps(times, 50.0),
        integrator=Sdirk2(),
        readout=at_points(space, [(0.0, 0.0, 0.0)]),
    ).temperature[:, 0]
    share = convective_ball_centre(
        times, radius=0.1, diffusivity=48.822 / 4816800, biot=232.5 * 0.1 / 48.822
    )
    exact = 1000 - 980 * share
    stated = [341.9, 494.3, 611.5, 701.5, 770.6, 823.8, 864.6, 896.0, 920.1, 938.6, 952.8]
    np.testing.assert_allclose(exact, stated, atol=0.06)
    np.testing.assert_allclose(got, exact, atol=0.5)


def test_nafems_t4_steady_convection() -> None:
    space = discretise(promote(box_mesh((0.6, 1.0, 0.05), (12, 20, 1))))
    surface = Convection(on_faces_towards(space, AXES[0], AXES[1], value=750.0), 0.0)
    base = held(space, (space.mesh.nodes[:, 1] < 1e-9, constant(100.0)))
    model = Model(
        space, in_cells(space, 52.0), in_cells(space, 1.0), surface=(surface,), prescribed=base
    )
    got = simulate(
        model,
        everywhere(space, 0.0),
        uniform_steps(np.array([1e9]), 1e9),
        integrator=BackwardEuler(),
        readout=at_points(space, [(0.6, 0.2, 0.05), (0.6, 0.2, 0.0)]),
    ).temperature[0]
    exact = 100 * plate_with_two_convective_sides(
        0.6, 0.2, width=0.6, height=1.0, biot=750 * 0.6 / 52
    )
    assert abs(exact - 18.254) < 1e-3
    np.testing.assert_allclose(got, exact, atol=0.1)


def test_orthotropic_box_is_a_stretched_isotropic_one() -> None:
    stretch = np.array([1.0, 2.0, 0.5])
    plain = discretise(box_mesh((0.1, 0.1, 0.1), (2, 2, 2)))
    long = discretise(box_mesh(tuple(0.1 * stretch), (2, 2, 2)))
    tensor = jnp.broadcast_to(jnp.diag(jnp.asarray(3.0 * stretch**2)), (48, 3, 3))
    grid = uniform_steps(np.array([400.0, 2000.0]), 100.0)

    def run(space, conductivity, scale):
        flux = PrescribedFlux(scale * on_faces_towards(space, AXES[0], value=5e3))
        middle = np.abs(space.mesh.nodes / space.mesh.nodes.max(0) - 0.5).max(1) < 1e-9
        fixed = held(space, (middle, constant(300.0)))
        model = Model(space, conductivity, in_cells(space, 2e6), (flux,), prescribed=fixed)
        read = every_node(len(space.mesh.nodes))
        solution = simulate(
            model, everywhere(space, 300.0), grid, integrator=Sdirk2(), readout=read
        )
        order = np.lexsort(np.round(space.mesh.nodes / space.mesh.nodes.max(0), 6).T)
        return np.asarray(solution.temperature)[:, order]

    straight = run(long, tensor, 1.0)
    isotropic = run(plain, jnp.full(48, 3.0), 1.0)
    assert np.ptp(isotropic) > 5
    np.testing.assert_allclose(straight, isotropic, rtol=0, atol=1e-5)
