"""Rows 11, 12, 15, 21 and 23 of the verification table: properties of temperature, radiation."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from thermo.physics import Model, uniform_steps
from thermo.physics.effects import (
    STEFAN_BOLTZMANN,
    Convection,
    History,
    PolynomialLaw,
    PrescribedFlux,
    Radiation,
)
from thermo.physics.integrators import Sdirk2

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

ZERO = 273.15


def linear_law(start: float, slope: float) -> PolynomialLaw:
    return PolynomialLaw(jnp.array([start, slope]), 0.0)


def test_ttnl303_conductivity_of_temperature() -> None:
    space = slab(0.2, 80, order=1)
    x = space.mesh.nodes[:, 0]
    left = History(jnp.array([0.0, 10.0, 10.0 + 1e-9]), jnp.array([200.0, 200.0, 100.0]))
    model = Model(
        space,
        in_cells(space, 1.0),
        in_cells(space, 8e6),
        prescribed=held(space, (x < 1e-9, left), (x > 0.2 - 1e-9, constant(100.0))),
        conductivity_law=linear_law(200.0, 1.0),
    )
    got = simulate(
        model,
        everywhere(space, 100.0),
        uniform_steps(np.array([10.0, 13.0]), 0.1),
        integrator=Sdirk2(iterations=2),
        readout=at_sections(space, [0.01, 0.02, 0.04, 0.06, 0.08, 0.10]),
    ).temperature
    stated = [176.165, 153.213, 118.600, 103.715, 100.368, 100.014]
    np.testing.assert_allclose(got[0], stated, rtol=0.01)
    volumes = [  # 800 finite volumes and a stiff solver at 1e-8, for this test
        [175.613, 152.256, 117.856, 103.682, 100.456, 100.034],
        [125.466, 136.006, 122.951, 106.982, 101.356, 100.178],
    ]
    np.testing.assert_allclose(got, volumes, atol=0.06)


def test_ttnl302_conductivity_and_capacity_of_temperature() -> None:
    space = slab(3.0, 120, order=1)
    law = linear_law(1.0, 0.5)
    model = Model(
        space,
        in_cells(space, 1.0),
        in_cells(space, 1.0),
        surface=(PrescribedFlux(on_faces_towards(space, FRONT)),),
        conductivity_law=law,
        capacity_law=law,
    )
    got = simulate(
        model,
        everywhere(space, 0.0),
        growing_steps([0.1, 0.3, 0.5, 0.7, 1.0], 1e-3, 1.05),
        integrator=Sdirk2(iterations=2),
        readout=at_sections(space, [0.0, 1.0]),
    ).temperature
    stated = [[0.33, 0.544, 0.682, 0.789, 0.918], [0.004, 0.071, 0.16, 0.247, 0.366]]
    np.testing.assert_allclose(got.T, stated, atol=1.2e-3)
    volumes = [  # 1200 finite volumes and a stiff solver at 1e-8, for this test
        [0.32966, 0.54404, 0.68170, 0.78860, 0.91780],
        [0.00394, 0.07065, 0.16021, 0.24724, 0.36595],
    ]
    np.testing.assert_allclose(got.T, volumes, atol=5e-5)


def test_sfpe_1_plate_in_a_standard_fire() -> None:
    space = slab(0.02, 4, order=1)  # half of the plate
    time = 1800 * np.linspace(0, 1, 2001) ** 2
    fire = 20 + 345 * np.log10(8 * time / 60 + 1) + ZERO
    gas = History(jnp.asarray(time), jnp.asarray(fire))
    model = Model(
        space,
        in_cells(space, 500.0),
        in_cells(space, 7850.0 * 520.0),
        surface=(
            Convection(on_faces_towards(space, BACK, value=25.0), gas),
            Radiation(on_faces_towards(space, BACK, value=0.7), gas),
        ),
    )
    got = simulate(
        model,
        everywhere(space, 20 + ZERO),
        uniform_steps(np.arange(300.0, 1801.0, 300.0), 5.0),
        integrator=Sdirk2(),
        readout=at_sections(space, [0.01]),
    ).temperature[:, 0]
    np.testing.assert_allclose(got - ZERO, [97.8, 234.4, 390.2, 539.7, 662.9, 751.9], atol=0.6)


def test_nafems_t2_steady_radiation() -> None:
    space = slab(0.1, 10, order=1)
    x = space.mesh.nodes[:, 0]
    model = Model(
        space,
        in_cells(space, 55.6),
        in_cells(space, 1e6),
        surface=(Radiation(on_faces_towards(space, BACK, value=0.98), 300.0),),
        prescribed=held(space, (x < 1e-9, constant(1000.0))),
    )
    end = simulate(
        model,
        everywhere(space, 1000.0),
        growing_steps([1e5], 5.0, 1.3),
        integrator=Sdirk2(),
        readout=at_sections(space, [0.1]),
    ).temperature[0, 0]
    assert abs(float(end) - 927.01) < 0.02
    conducted = 55.6 * (1000 - end) / 0.1
    radiated = 0.98 * STEFAN_BOLTZMANN * (end**4 - 300**4)
    assert abs(float(conducted / radiated) - 1) < 1e-6


def test_steady_flux_through_a_radiating_slab() -> None:
    space = slab(1.0, 4, order=1)
    model = Model(
        space,
        in_cells(space, 50.0),
        in_cells(space, 1e6),
        surface=(
            PrescribedFlux(on_faces_towards(space, FRONT, value=1200.0)),
            Radiation(on_faces_towards(space, BACK, value=0.8), 20 + ZERO),
        ),
    )
    got = simulate(
        model,
        everywhere(space, 430.0),
        growing_steps([1e8], 1e3, 1.5),
        integrator=Sdirk2(),
        readout=at_sections(space, [0.0, 0.5, 1.0]),
    ).temperature[0]
    np.testing.assert_allclose(got - ZERO, [179.747, 167.747, 155.747], atol=2e-3)
