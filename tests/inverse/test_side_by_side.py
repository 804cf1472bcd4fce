"""Runs side by side: each model's own answer, in the order of the models."""

from __future__ import annotations

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from thermo.inverse import _side_by_side as module
from thermo.inverse._conditions import conditions, make_model
from thermo.inverse._properties import Stated, properties
from thermo.inverse._side_by_side import solve_each
from thermo.observe import Scene
from thermo.physics import (
    ConjugateGradient,
    Model,
    ReadOut,
    discretise,
    every_node,
    every_step,
    solve_heat,
    uniform_steps,
)
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

    @eqx.filter_jit
    def alone(model: Model) -> Array:
        return solve_heat(
            model,
            jnp.asarray(under.start(count)),
            grid,
            integrator=Sdirk2(),
            readout=readout,
            solver=ConjugateGradient(rtol=1e-9),
        ).temperature

    for model, temperature in zip(models, found, strict=True):
        np.testing.assert_allclose(temperature, alone(model), rtol=0, atol=1e-3)
    ends = np.array([temperature[-1].mean() for temperature in found])
    assert (np.abs(np.subtract.outer(ends, ends)) + np.eye(len(values)) > 0.01).all()


def test_runs_of_alike_numbers_of_steps_share_a_program(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    space, traced = discretise(MESH), []

    def solve(*given: object, **more: object) -> object:
        traced.append(given)
        return solve_heat(*given, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(module, "solve_heat", solve)
    under = conditions(scene.runs["cooling"], space)
    stated = properties(Stated(1.0, 2e6, 10.0, 0.8), {}, len(MESH.cells), len(MESH.faces))
    model = make_model(space, stated, under)
    # So many samples has no other test here, whose program would serve.
    readout = ReadOut(np.arange(17)[:, None], np.ones((17, 1)))
    grids = [
        every_step(uniform_steps(np.array([0.0, 7.3, end]), 1.0, (2.6,))) for end in (20.0, 30.0)
    ]
    assert len(grids[0].start) != len(grids[1].start) and not any(grid.even for grid in grids)
    for grid in grids:
        (found,) = solve_each([model], under, grid, readout)
        assert found.shape == (len(grid.frame_time), 17)
    assert len(traced) == 1


def test_on_many_nodes_few_steps_are_filled_up() -> None:
    """A step of no duration takes time there as well: a quarter more at most."""
    few, many = module.FEW_NODES - 1, module.FEW_NODES
    for count in range(1, 300):
        shared = module._shared(count, few)
        assert count <= shared < 2 * count and shared & (shared - 1) == 0
        assert count <= module._shared(count, many) <= 1.25 * count
