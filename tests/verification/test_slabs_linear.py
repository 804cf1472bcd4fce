"""Rows 1, 3 and 8a of the verification table, and a wall of two layers."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from thermo.physics import Model, uniform_steps
from thermo.physics.effects import Convection, History
from thermo.physics.integrators import BackwardEuler, Sdirk2

from .bodies import (
    BACK,
    FRONT,
    at_sections,
    constant,
    everywhere,
    growing_steps,
    held,
    in_cells,
    on_faces_towards,
    simulate,
    slab,
)
from .closed_forms import convective_slab, sine_driven_slab, two_layer_wall


def test_nafems_t3_one_end_follows_a_sine() -> None:
    space = slab(0.1, 20)
    x = space.mesh.nodes[:, 0]
    times = np.linspace(0, 32, 1281)
    drive = History(jnp.asarray(times), jnp.asarray(100 * np.sin(np.pi * times / 40)))
    ends = held(space, (x < 1e-9, constant(0.0)), (x > 0.1 - 1e-9, drive))
    model = Model(space, in_cells(space, 35.0), in_cells(space, 440.5 * 7200), prescribed=ends)
    solution = simulate(
        model,
        everywhere(space, 0.0),
        uniform_steps(np.array([32.0]), 0.2),
        integrator=Sdirk2(),
        readout=at_sections(space, [0.08]),
    )
    exact = 100 * sine_driven_slab(
        0.08, 32.0, length=0.1, diffusivity=35 / (440.5 * 7200), omega=np.pi / 40
    )
    assert abs(exact - 36.60) < 5e-3
    np.testing.assert_allclose(solution.temperature, [[exact]], atol=5e-3)


def cooled_slab(space, conductivity, capacity, coefficient, initial, ambient, grid, places):
    surface = Convection(on_faces_towards(space, BACK, value=coefficient), ambient)
    model = Model(
        space, in_cells(space, conductivity), in_cells(space, capacity), surface=(surface,)
    )
    return simulate(
        model,
        everywhere(space, initial),
        grid,
        integrator=Sdirk2(),
        readout=at_sections(space, places),
    ).temperature


def test_ttll100_convective_cooling() -> None:
    times, places = np.array([0.1, 0.5, 2.0, 10.0]), np.array([0.02, 0.08])
    got = cooled_slab(
        slab(0.1, 20), 1.0, 1000.0, 100.0, 100.0, 0.0, growing_steps(times, 0.002, 1.04), places
    )
    exact = 100 * convective_slab(places, times, length=0.1, diffusivity=1e-3, biot=10.0)
    np.testing.assert_allclose(got, exact, atol=0.02)
    stated = np.array([[100, 93.666], [99.408, 63.5], [79.859, 35.717], [15.717, 6.795]])
    np.testing.assert_allclose(got, stated, atol=0.08)


def test_fds_heat_conduction_a() -> None:
    times, depths = np.array([500.0, 1000.0, 2000.0]), np.array([0, 0.02, 0.04, 0.06, 0.08, 0.1])
    got = cooled_slab(
        slab(0.1, 20), 0.1, 1e5, 100.0, 20.0, 120.0, growing_steps(times, 2.0, 1.03), 0.1 - depths
    )
    exact = 120 - 100 * convective_slab(
        0.1 - depths, times, length=0.1, diffusivity=1e-6, biot=100.0
    )
    np.testing.assert_allclose(got, exact, atol=0.02)
    stated = [
        [117.48, 70.69, 39.50, 25.39, 21.06, 20.28],
        [118.22, 83.88, 55.97, 37.43, 27.70, 24.79],
        [118.75, 94.37, 72.77, 56.06, 45.61, 42.06],
    ]
    np.testing.assert_allclose(got, stated, atol=0.15)


def test_wall_of_two_layers_in_series() -> None:
    space = slab(0.1, 5, order=1)
    x, centre = space.mesh.nodes[:, 0], space.mesh.nodes[space.mesh.cells[:, :4]].mean(1)[:, 0]
    conductivity = jnp.asarray(np.where(centre < 0.04, 0.5, 12.0))
    ends = held(space, (x < 1e-9, constant(300.0)), (x > 0.1 - 1e-9, constant(350.0)))
    model = Model(space, conductivity, in_cells(space, 1.0), prescribed=ends)
    steady = simulate(
        model,
        everywhere(space, 320.0),
        uniform_steps(np.array([1e9]), 1e9),
        integrator=BackwardEuler(),
    )
    exact = 300 + 50 * two_layer_wall(x, lengths=(0.04, 0.06), conductivities=(0.5, 12.0))
    np.testing.assert_allclose(steady.final, exact, atol=1e-5)


def test_slab_between_two_airs() -> None:
    space = slab(0.1, 5, order=1)
    film = on_faces_towards(space, FRONT, value=8.0) + on_faces_towards(space, BACK, value=25.0)
    warmer = on_faces_towards(space, BACK, value=60.0)
    model = Model(
        space, in_cells(space, 0.5), in_cells(space, 1.0),
        surface=(Convection(film, 290.0, warmer),),
    )  # fmt: skip
    steady = simulate(
        model,
        everywhere(space, 320.0),
        uniform_steps(np.array([1e9]), 1e9),
        integrator=BackwardEuler(),
    )
    # Two films and a wall in series between air of 290 and of 350 K.
    flux = 60.0 / (1 / 8.0 + 0.1 / 0.5 + 1 / 25.0)
    exact = 290.0 + flux * (1 / 8.0 + space.mesh.nodes[:, 0] / 0.5)
    np.testing.assert_allclose(steady.final, exact, atol=1e-5)
