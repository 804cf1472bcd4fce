"""Runs side by side: each model's own answer, in the order of the models."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from thermo.inverse._conditions import conditions, make_model
from thermo.inverse._properties import Stated, properties
from thermo.inverse._side_by_side import solve_each
from thermo.observe import Scene
from thermo.physics import ConjugateGradient, discretise, every_node, solve_heat, uniform_steps
from thermo.physics.integrators import Sdirk2

from .objectives import MESH


def test_each_model_has_its_own_answer_in_its_place(scene: Scene) -> None:
    space = discretise(MESH)
    under = conditions(scene.runs["cooling"], space)
    sizes = (len(MESH.cells), len(MESH.faces))
    values = (0.3, 3.0, 30.0, 1.0, 10.0)
    models = [
        make_model(space, properties(Stated(value, 2e6, 10.0, 0.8), {}, *sizes), under)
        for value in values
    ]
    count = len(space.mesh.nodes)
    grid, readout = uniform_steps(np.array([0.0, 5.0, 20.0]), 1.0), every_node(count)
    found = solve_each(models, under, grid, readout)
    for model, temperature in zip(models, found, strict=True):
        alone = solve_heat(
            model,
            jnp.asarray(under.start(count)),
            grid,
            integrator=Sdirk2(),
            readout=readout,
            solver=ConjugateGradient(rtol=1e-9),
        ).temperature
        np.testing.assert_allclose(temperature, alone, rtol=0, atol=1e-3)
    ends = np.array([temperature[-1].mean() for temperature in found])
    assert (np.abs(np.subtract.outer(ends, ends)) + np.eye(len(values)) > 0.01).all()
