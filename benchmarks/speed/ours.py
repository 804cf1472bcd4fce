"""ThermoField on the problems of the comparison."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from problem import CONVECTION, EMISSIVITY, SIZE, START, SURROUNDINGS, Problem

from thermo.physics import (
    AbstractAdjoint,
    ConjugateGradient,
    ForwardOnly,
    Model,
    ReadOut,
    RecomputeSegments,
    StoreSteps,
    discretise,
    solve_heat,
    uniform_steps,
)
from thermo.physics.effects import Convection, Radiation
from thermo.physics.integrators import BackwardEuler

COLUMNS, SAMPLES = 32, 500
"""Directions of the Jacobian, and surface nodes at which it is taken, as a camera may read."""


class Ours:
    """One problem, discretised.

    `adjoint`: `store`, or `segments` of the square root of the steps.
    """

    def __init__(self, problem: Problem, rtol: float, adjoint: str = "store") -> None:
        self.problem, self.rtol = problem, rtol
        self.space = discretise(problem.mesh)
        faces, cells = len(self.space.mesh.faces), len(self.space.mesh.cells)
        surface = (
            Convection(jnp.full(faces, CONVECTION), SURROUNDINGS),
            Radiation(jnp.full(faces, EMISSIVITY), SURROUNDINGS),
        )
        capacity = jnp.full(cells, problem.capacity)
        self.model = Model(self.space, jnp.asarray(problem.conductivity), capacity, surface)
        nodes = np.unique(self.space.mesh.faces)
        self.places = self.space.mesh.nodes[nodes]
        self.readout = ReadOut(nodes[:, None].astype(np.int32), np.ones((len(nodes), 1)))
        times = np.arange(1, problem.steps + 1) * SIZE
        self.grid = uniform_steps(times, SIZE)
        length = max(int(np.sqrt(problem.steps)), 1)
        self.adjoint: AbstractAdjoint = (
            RecomputeSegments(length) if adjoint == "segments" else StoreSteps()
        )

    def run(
        self, model: Model, conductivity: jax.Array, tangents: ReadOut | None = None
    ) -> jax.Array:
        """Temperatures [K] at the read-out, or for `tangents`, with another conductivity."""
        changed = eqx.tree_at(lambda m: m.conductivity, model, conductivity)
        return solve_heat(
            changed,
            jnp.full(len(self.space.mesh.nodes), START),
            self.grid,
            integrator=BackwardEuler(),
            readout=self.readout if tangents is None else tangents,
            solver=ConjugateGradient(rtol=self.rtol),
            adjoint=self.adjoint if tangents is None else ForwardOnly(),
        ).temperature

    def forward(self):  # noqa: ANN201
        """A compiled run: from the model and the conductivity to surface temperatures [K]."""
        run = eqx.filter_jit(self.run)
        return lambda conductivity: run(self.model, conductivity)

    def gradient(self, target: jax.Array):  # noqa: ANN201
        """A compiled gradient of the mean squared misfit by each cell's conductivity."""

        @eqx.filter_jit
        def slope(model: Model, conductivity: jax.Array, target: jax.Array) -> jax.Array:
            def misfit(k: jax.Array) -> jax.Array:
                return jnp.mean((self.run(model, k) - target) ** 2)

            return jax.grad(misfit)(conductivity)

        return lambda conductivity: slope(self.model, conductivity, target)

    def jacobian(self):  # noqa: ANN201
        """A compiled Jacobian of surface temperatures by COLUMNS patterns of conductivity."""
        centre = self.problem.mesh.nodes[self.problem.mesh.cells[:, :4]].mean(1)
        make = np.random.default_rng(0)
        waves = centre @ make.normal(size=(3, COLUMNS)) * 60
        ways = jnp.asarray(self.problem.conductivity[:, None] * np.sin(waves)).T

        picked = np.linspace(0, len(self.places) - 1, min(SAMPLES, len(self.places))).astype(int)
        few = ReadOut(np.asarray(self.readout.nodes)[picked], np.ones((len(picked), 1)))

        @eqx.filter_jit
        def columns(model: Model, conductivity: jax.Array, ways: jax.Array) -> jax.Array:
            def push(way: jax.Array) -> jax.Array:
                return jax.jvp(lambda k: self.run(model, k, few), (conductivity,), (way,))[1]

            return jax.vmap(push, out_axes=-1)(ways)

        return lambda conductivity: columns(self.model, conductivity, ways)
